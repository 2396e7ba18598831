// The shapes of the page, with what is derived from each.

const COARSE = 72;

/** A shape of the data with what is derived from it, made when first asked for. */
class Shape {
  constructor(spec, name) {
    this.spec = spec;
    this.name = name;
    this.lmax = spec.lmax;
    this.surfaces = {};
    this.full = {};
  }

  get series() {
    this.madeSeries ??= new Series(this.lmax, numbersOf(this.spec.coefficients, Float32Array));
    return this.madeSeries;
  }

  /** The mesh, or null. */
  get mesh() {
    if (this.spec.mesh) this.madeMesh ??= new Mesh(this.spec.mesh, this.spec.centre);
    return this.madeMesh ?? null;
  }

  get amplitudes() {
    this.measuredAmplitudes ??= this.series.amplitudes();
    return this.measuredAmplitudes;
  }

  /** Some five places for each wave of the highest degree, as far as memory is no matter. */
  grid(quality) {
    const fine = Math.min(Math.max(2.5 * this.lmax, 168), 504);
    return Grid.of(quality === 'coarse' ? COARSE : Math.ceil(fine / 24) * 24);
  }

  /** Evaluates on a grid; values are the differences from the full series. */
  evaluate(degree, quality) {
    const grid = this.grid(quality);
    this.surfaces[quality] ??= grid.surface();
    this.full[quality] ??= valuesOf(grid.evaluate(this.series, this.lmax, grid.surface()));
    const { vertices } = grid.evaluate(this.series, degree, this.surfaces[quality]);
    const full = this.full[quality];
    for (let v = 0; v < full.length; v++) {
      const at = v * STRIDE + 6;
      vertices[at] = degree === this.lmax ? 0 : vertices[at] - full[v];
    }
    return this.surfaces[quality];
  }

  /** The comparison with the mesh; null without a mesh or when its table would be too large. */
  get comparison() {
    const fits = this.mesh && this.mesh.count * (this.lmax + 1) <= Comparison.MOST;
    this.compared ??= fits ? new Comparison(this.series, this.mesh) : null;
    return this.compared;
  }

  /** The ball that the camera takes in. */
  get frame() {
    this.ball ??= this.measure();
    return this.ball;
  }

  measure() {
    const parts = [this.evaluate(this.lmax, 'coarse').vertices];
    if (this.mesh) parts.push(this.mesh.surface.vertices);
    const [low, high] = [[Infinity, Infinity, Infinity], [-Infinity, -Infinity, -Infinity]];
    eachPlace(parts, (place) => place.forEach((x, k) => {
      low[k] = Math.min(low[k], x);
      high[k] = Math.max(high[k], x);
    }));
    const centre = low.map((x, k) => (x + high[k]) / 2);
    let radius = 0;
    eachPlace(parts, (place) => {
      radius = Math.max(radius, Math.hypot(...place.map((x, k) => x - centre[k])));
    });
    return { centre, radius: radius || 1 };
  }

  /** What the degrees above add, RMS over the sphere. */
  remainder(degree) {
    return Math.hypot(...this.amplitudes.subarray(degree + 1));
  }
}

function eachPlace(parts, act) {
  for (const vertices of parts)
    for (let at = 0; at < vertices.length; at += STRIDE) act([...vertices.subarray(at, at + 3)]);
}

/** Numbers the shapes that bear the same name. */
function namedShapes(specs) {
  const count = (name) => specs.filter((spec) => spec.name === name).length;
  return specs.map((spec, i) => {
    const before = specs.slice(0, i).filter((other) => other.name === spec.name).length;
    return new Shape(spec, count(spec.name) > 1 ? `${spec.name} (${before + 1})` : spec.name);
  });
}
