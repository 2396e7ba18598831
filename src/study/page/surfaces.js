// Surfaces that are drawn: a series on a grid, a mesh, a series along the vertices of a mesh.

const STRIDE = 7; // place, normal, value

/** Vertices are relative to the centre of the shape; `version` counts their changes. */
const surface = (count, triangles, lines) =>
  ({ vertices: new Float32Array(count * STRIDE), triangles, lines, version: 0 });

const valuesOf = ({ vertices }) =>
  Float32Array.from({ length: vertices.length / STRIDE }, (_, v) => vertices[v * STRIDE + 6]);

/** Latitudes and longitudes with what does not depend on the shape; rings are a multiple of 24. */
class Grid {
  static made = new Map();

  static of(rings) {
    if (!Grid.made.has(rings)) Grid.made.set(rings, new Grid(rings));
    return Grid.made.get(rings);
  }

  constructor(rings) {
    const n = 2 * rings;
    const turn = Float64Array.from({ length: n }, (_, j) => (2 * Math.PI * j) / n);
    this.rings = rings;
    this.circle = { n, cos: turn.map(Math.cos), sin: turn.map(Math.sin) };
    // The poles are rings too, too small to be seen: a normal needs a direction.
    this.thetas = Float64Array.from({ length: rings + 1 }, (_, i) =>
      Math.min(Math.max((Math.PI * i) / rings, 1e-6), Math.PI - 1e-6));
    this.triangles = new Uint32Array(rings * n * 6);
    for (let i = 0, at = 0; i < rings; i++) {
      for (let j = 0; j < n; j++, at += 6) {
        const [p, q] = [i * n + j, i * n + ((j + 1) % n)];
        this.triangles.set([p, p + n, q, q, p + n, q + n], at);
      }
    }
    this.lines = this.graticule(rings / 24);
  }

  /** Parallels and meridians every 7.5 degrees, whatever the grid. */
  graticule(step) {
    const n = this.circle.n;
    const lines = [];
    for (let i = step; i < this.rings; i += step)
      for (let j = 0; j < n; j++) lines.push(i * n + j, i * n + ((j + 1) % n));
    for (let j = 0; j < n; j += step)
      for (let i = 0; i < this.rings; i++) lines.push(i * n + j, (i + 1) * n + j);
    return Uint32Array.from(lines);
  }

  surface() {
    return surface((this.rings + 1) * this.circle.n, this.triangles, this.lines);
  }

  /** Fills the vertices with the series at a degree; values are its radii. */
  evaluate(series, degree, target) {
    const sums = () => new Float64Array(degree + 2);
    const [a, b, da, db, pa, pb] = [sums(), sums(), sums(), sums(), sums(), sums()];
    const { n } = this.circle;
    const [r, dTheta, dPhi] = [new Float64Array(n), new Float64Array(n), new Float64Array(n)];
    for (let i = 0; i <= this.rings; i++) {
      series.sumDegrees(degree, this.thetas[i], { a, b, da, db });
      for (let m = 0; m <= degree; m++) {
        pa[m] = m * b[m];
        pb[m] = -m * a[m];
      }
      sumOrders(a, b, degree, this.circle, r);
      sumOrders(da, db, degree, this.circle, dTheta);
      sumOrders(pa, pb, degree, this.circle, dPhi);
      this.fillRing(i, r, dTheta, dPhi, target.vertices);
    }
    target.version++;
    return target;
  }

  /** The normal is r e_r - dr/dtheta e_theta - dr/dphi / sin theta e_phi, at unit length. */
  fillRing(i, r, dTheta, dPhi, vertices) {
    const { n, cos, sin } = this.circle;
    const [x, s] = [Math.cos(this.thetas[i]), Math.sin(this.thetas[i])];
    for (let j = 0, at = i * n * STRIDE; j < n; j++, at += STRIDE) {
      const across = r[j] * s - dTheta[j] * x;
      const along = dPhi[j] / s;
      const nx = across * cos[j] + along * sin[j];
      const ny = across * sin[j] - along * cos[j];
      const nz = r[j] * x + dTheta[j] * s;
      const scale = 1 / Math.sqrt(nx * nx + ny * ny + nz * nz);
      vertices[at] = r[j] * s * cos[j];
      vertices[at + 1] = r[j] * s * sin[j];
      vertices[at + 2] = r[j] * x;
      vertices[at + 3] = nx * scale;
      vertices[at + 4] = ny * scale;
      vertices[at + 5] = nz * scale;
      vertices[at + 6] = r[j];
    }
  }
}

/** Sets the normals from the faces, weighted by their areas. */
function setNormals({ vertices, triangles }) {
  for (let at = 0; at < vertices.length; at += STRIDE) vertices.fill(0, at + 3, at + 6);
  for (let t = 0; t < triangles.length; t += 3) {
    const [a, b, c] = [triangles[t] * STRIDE, triangles[t + 1] * STRIDE, triangles[t + 2] * STRIDE];
    const ux = vertices[b] - vertices[a];
    const uy = vertices[b + 1] - vertices[a + 1];
    const uz = vertices[b + 2] - vertices[a + 2];
    const vx = vertices[c] - vertices[a];
    const vy = vertices[c + 1] - vertices[a + 1];
    const vz = vertices[c + 2] - vertices[a + 2];
    const nx = uy * vz - uz * vy;
    const ny = uz * vx - ux * vz;
    const nz = ux * vy - uy * vx;
    for (const at of [a, b, c]) {
      vertices[at + 3] += nx;
      vertices[at + 4] += ny;
      vertices[at + 5] += nz;
    }
  }
  for (let at = 3; at < vertices.length; at += STRIDE) {
    const [x, y, z] = [vertices[at], vertices[at + 1], vertices[at + 2]];
    const length = Math.sqrt(x * x + y * y + z * z) || 1;
    for (let k = at; k < at + 3; k++) vertices[k] /= length;
  }
}

/** The mesh of a shape, and the series pushed to the same directions for the comparison. */
class Mesh {
  constructor(mesh, centre) {
    const packed = numbersOf(mesh.positions, Uint16Array);
    const triangles = numbersOf(mesh.faces, Uint32Array);
    this.count = Math.floor(packed.length / 3);
    this.faces = triangles.length / 3;
    this.facesOfOriginal = mesh.faces_of_original ?? this.faces;
    this.step = Math.max(...[0, 1, 2].map((k) => mesh.max[k] - mesh.min[k])) / 65535;
    const lines = [];
    for (let t = 0; t < triangles.length; t += 3) {
      for (let k = 0; k < 3; k++) {
        // A closed mesh has each edge twice, once in either direction.
        const [p, q] = [triangles[t + k], triangles[t + ((k + 1) % 3)]];
        if (p < q) lines.push(p, q);
      }
    }
    this.surface = surface(this.count, triangles, Uint32Array.from(lines));
    this.radii = new Float64Array(this.count);
    for (let v = 0; v < this.count; v++) {
      const place = [0, 1, 2].map((k) =>
        mesh.min[k] + ((mesh.max[k] - mesh.min[k]) * packed[3 * v + k]) / 65535 - centre[k]);
      this.surface.vertices.set(place, v * STRIDE);
      this.radii[v] = Math.hypot(...place);
    }
    setNormals(this.surface);
  }
}

/** Radii of the series at the vertices of the mesh for all degrees, filled a slice at a time. */
class Comparison {
  static MOST = 5e7; // numbers of four bytes

  constructor(series, mesh) {
    this.mesh = mesh;
    this.series = series;
    this.done = 0;
    this.table = new Float32Array((series.lmax + 1) * mesh.count);
    this.surface = surface(mesh.count, mesh.surface.triangles, mesh.surface.lines);
  }

  get ready() {
    return this.done === this.mesh.count;
  }

  /** Goes on for some milliseconds. */
  work(milliseconds) {
    const end = performance.now() + milliseconds;
    const radii = new Float64Array(this.series.lmax + 1);
    const { vertices } = this.mesh.surface;
    while (!this.ready && performance.now() < end) {
      const at = this.done * STRIDE;
      const r = this.mesh.radii[this.done] || 1;
      this.series.radii([vertices[at] / r, vertices[at + 1] / r, vertices[at + 2] / r], radii);
      for (let l = 0; l < radii.length; l++) this.table[l * this.mesh.count + this.done] = radii[l];
      this.done++;
    }
  }

  /** Moves the vertices of the mesh to the series along their directions; values are how far. */
  evaluate(degree) {
    const { vertices } = this.surface;
    const from = this.mesh.surface.vertices;
    for (let v = 0, at = 0; v < this.mesh.count; v++, at += STRIDE) {
      const radius = this.table[degree * this.mesh.count + v];
      const scale = radius / (this.mesh.radii[v] || 1);
      for (let k = 0; k < 3; k++) vertices[at + k] = from[at + k] * scale;
      vertices[at + 6] = radius - this.mesh.radii[v];
    }
    setNormals(this.surface);
    this.surface.version++;
    return this.surface;
  }
}
