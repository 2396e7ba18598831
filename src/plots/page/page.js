// The page of shapes: evaluates each series in the browser and draws it beside its mesh.
//
// Everything is in this file: no library, no network. Names come from files of others, so text is
// set as text and elements are made one by one. Lengths are metres, the basis is that of
// docs/conventions.md.
(() => {
'use strict';

const data = JSON.parse(document.getElementById('data').textContent);

// ---------------------------------------------------------------------------------------------
// Elements and words

const byId = (id) => document.getElementById(id);

/** Makes an element with properties and children; text is never read as markup. */
function element(tag, properties = {}, ...children) {
  const made = Object.assign(document.createElement(tag), properties);
  made.append(...children);
  return made;
}

/** Makes an element of SVG with attributes. */
function drawn(tag, attributes = {}, text = '') {
  const made = document.createElementNS('http://www.w3.org/2000/svg', tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  made.textContent = text;
  return made;
}

const grouped = (digits) => digits.replace(/\B(?=(\d{3})+(?!\d))/g, '\u202f');

const superscript = (exponent) =>
  String(exponent).replace(/[-\d]/g, (c) => '⁻⁰¹²³⁴⁵⁶⁷⁸⁹'['-0123456789'.indexOf(c)]);

/** Writes a number with a few significant digits, integers in full. */
function formatNumber(value, digits = 3) {
  if (!Number.isFinite(value)) return String(value);
  const size = Math.abs(value);
  let text;
  if (Number.isInteger(value) && size < 1e15) text = grouped(String(size));
  else if (size >= 1e6 || size < 1e-4) {
    const [mantissa, exponent] = size.toExponential(digits - 1).split('e');
    text = `${mantissa}×10${superscript(Number(exponent))}`;
  } else if (size >= 10 ** digits) text = grouped(String(Math.round(size)));
  else text = size.toPrecision(digits);
  return value < 0 ? `−${text}` : text;
}

const LENGTHS = [['km', 1e3], ['m', 1], ['mm', 1e-3], ['µm', 1e-6], ['nm', 1e-9]];

/** Finds the unit in which a length is best written. */
const lengthUnit = (metres) =>
  LENGTHS.find(([, unit]) => Math.abs(metres) >= unit * 0.99999) ?? LENGTHS.at(-1);

function formatLength(metres, digits = 3) {
  if (metres === 0) return '0 m';
  const [name, unit] = lengthUnit(metres);
  const inUnit = metres / unit;
  const whole = Math.round(inUnit);
  return `${formatNumber(Math.abs(inUnit - whole) < 1e-9 * whole ? whole : inUnit, digits)} ${name}`;
}

/** Writes a measured value; `unit` is empty where the head of the table bears it. */
function formatValue(value, column, withUnit) {
  if (value === null || value === undefined) return '–';
  if (typeof value !== 'number') return String(value);
  const scaled = value * (column.scale ?? 1);
  if (!withUnit) return formatNumber(scaled);
  if (column.unit === 'm') return formatLength(scaled);
  const unit = { bytes: 'B', deg: '°' }[column.unit] ?? column.unit ?? '';
  return unit === '' ? formatNumber(scaled) : `${formatNumber(scaled)} ${unit}`;
}

// ---------------------------------------------------------------------------------------------
// Numbers of the data

function bytesOf(base64) {
  const text = atob(base64);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; i++) bytes[i] = text.charCodeAt(i);
  return new DataView(bytes.buffer);
}

/** Reads little-endian numbers, whatever the order of the machine. */
function numbersOf(base64, Type) {
  const view = bytesOf(base64);
  const size = Type.BYTES_PER_ELEMENT;
  const read = { Uint16Array: 'getUint16', Uint32Array: 'getUint32', Float32Array: 'getFloat32' };
  const numbers = new Type(Math.floor(view.byteLength / size));
  for (let i = 0; i < numbers.length; i++) numbers[i] = view[read[Type.name]](i * size, true);
  return numbers;
}

// ---------------------------------------------------------------------------------------------
// The series

/**
 * A series of semi-normalised functions with the Condon-Shortley phase. Storage is order by order:
 * for each m the degrees m..lmax, with the factors of the recurrence
 * Q_l = alpha x Q_{l-1} - beta Q_{l-2}.
 */
class Series {
  constructor(lmax, coefficients) {
    const size = ((lmax + 1) * (lmax + 2)) / 2;
    this.lmax = lmax;
    this.cosine = new Float64Array(size);
    this.sine = new Float64Array(size);
    this.alpha = new Float64Array(size);
    this.beta = new Float64Array(size);
    for (let m = 0, at = 0; m <= lmax; m++) {
      for (let l = m; l <= lmax; l++, at++) {
        this.cosine[at] = coefficients[l * l + Math.max(2 * m - 1, 0)];
        this.sine[at] = m > 0 ? coefficients[l * l + 2 * m] : 0;
        const root = Math.sqrt(l * l - m * m);
        this.alpha[at] = (2 * l - 1) / root;
        this.beta[at] = Math.sqrt(Math.max((l - 1) ** 2 - m * m, 0)) / root;
      }
    }
  }

  /** Where the degrees of an order begin. */
  begin(m) {
    return m * (this.lmax + 1) - (m * (m - 1)) / 2;
  }

  /**
   * Sums over degrees on a ring: what multiplies cos m phi and sin m phi in the radius (`a`, `b`)
   * and in its derivative by theta (`da`, `db`), each of at least degree + 2 numbers.
   */
  sumDegrees(degree, theta, { a, b, da, db }) {
    const { cosine, sine, alpha, beta } = this;
    const x = Math.cos(theta);
    const s = Math.sin(theta);
    let first = 1;
    let dFirst = 0;
    for (let m = 0; m <= degree; m++) {
      if (m > 0) {
        const factor = -Math.sqrt((2 * m - 1) / (2 * m));
        dFirst = factor * (x * first + s * dFirst);
        first *= factor * s;
      }
      let at = this.begin(m);
      let [q, dq, last, dLast] = [first, dFirst, 0, 0];
      let [sa, sb, dsa, dsb] = [cosine[at] * q, sine[at] * q, cosine[at] * dq, sine[at] * dq];
      for (let l = m + 1; l <= degree; l++) {
        at++;
        const next = alpha[at] * x * q - beta[at] * last;
        const dNext = alpha[at] * (x * dq - s * q) - beta[at] * dLast;
        last = q;
        dLast = dq;
        q = next;
        dq = dNext;
        sa += cosine[at] * q;
        sb += sine[at] * q;
        dsa += cosine[at] * dq;
        dsb += sine[at] * dq;
      }
      a[m] = sa;
      b[m] = sb;
      da[m] = dsa;
      db[m] = dsb;
    }
    for (const sums of [a, b, da, db]) sums[degree + 1] = 0;
  }

  /** Fills the radii in a direction, cut at each degree from 0 to lmax. */
  radii([x, y, z], out) {
    const { cosine, sine, alpha, beta, lmax } = this;
    const s = Math.hypot(x, y);
    const [cx, sx] = s > 0 ? [x / s, y / s] : [1, 0];
    let [first, cm, sm, at] = [1, 1, 0, 0];
    out.fill(0);
    for (let m = 0; m <= lmax; m++) {
      if (m > 0) {
        first *= -Math.sqrt((2 * m - 1) / (2 * m)) * s;
        [cm, sm] = [cm * cx - sm * sx, cm * sx + sm * cx];
      }
      let [q, last] = [first, 0];
      for (let l = m; l <= lmax; l++, at++) {
        if (l > m) [q, last] = [alpha[at] * z * q - beta[at] * last, q];
        out[l] += (cosine[at] * cm + sine[at] * sm) * q;
      }
    }
    for (let l = 1; l <= lmax; l++) out[l] += out[l - 1];
    return out;
  }

  /** The root mean square over the sphere of the part of each degree. */
  amplitudes() {
    const squares = new Float64Array(this.lmax + 1);
    for (let m = 0, at = 0; m <= this.lmax; m++) {
      for (let l = m; l <= this.lmax; l++, at++) {
        const weight = (m === 0 ? 1 : 0.5) / (2 * l + 1);
        squares[l] += weight * (this.cosine[at] ** 2 + this.sine[at] ** 2);
      }
    }
    return squares.map(Math.sqrt);
  }
}

/**
 * Sums over orders on a ring of n longitudes, n a multiple of 4. Even and odd orders are summed
 * apart: by their signs one sum serves phi, -phi, pi - phi and pi + phi.
 */
function sumOrders(a, b, degree, circle, out) {
  const { cos, sin, n } = circle;
  for (let j = 0; j <= n / 4; j++) {
    let [ce, co, se, so] = [0, 0, 0, 0];
    for (let m = 0, k = 0; m <= degree; m += 2) {
      ce += a[m] * cos[k];
      se += b[m] * sin[k];
      k += j;
      if (k >= n) k -= n;
      co += a[m + 1] * cos[k];
      so += b[m + 1] * sin[k];
      k += j;
      if (k >= n) k -= n;
    }
    out[j] = ce + co + se + so;
    out[(n - j) % n] = ce + co - se - so;
    out[n / 2 - j] = ce - co - se + so;
    out[n / 2 + j] = ce - co + se - so;
  }
}

// ---------------------------------------------------------------------------------------------
// Surfaces: what the renderers draw

const STRIDE = 7; // place, normal, value

/** Vertices are relative to the centre of the shape; `version` counts their changes. */
const surface = (count, triangles, lines) =>
  ({ vertices: new Float32Array(count * STRIDE), triangles, lines, version: 0 });

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

// ---------------------------------------------------------------------------------------------
// Shapes

const COARSE = 120;

/** A shape of the data with what is derived from it, made when first asked for. */
class Shape {
  constructor(spec, name) {
    this.spec = spec;
    this.name = name;
    this.lmax = spec.lmax;
    this.series = new Series(spec.lmax, numbersOf(spec.coefficients, Float32Array));
    this.amplitudes = this.series.amplitudes();
    this.mesh = spec.mesh ? new Mesh(spec.mesh, spec.centre) : null;
    const fine = Math.min(Math.max(2.5 * spec.lmax, 168), 504);
    this.grids = { coarse: Grid.of(COARSE), fine: Grid.of(Math.ceil(fine / 24) * 24) };
    this.surfaces = {};
    this.full = {};
  }

  /** Evaluates on a grid; values are the differences from the full series. */
  evaluate(degree, quality) {
    const grid = this.grids[quality];
    this.surfaces[quality] ??= grid.surface();
    this.full[quality] ??= grid.evaluate(this.series, this.lmax, grid.surface()).vertices
      .filter((_, i) => i % STRIDE === 6);
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

// ---------------------------------------------------------------------------------------------
// The camera: z up, looking from -y towards +y at first

const HALF_VIEW = Math.tan((28 / 2) * (Math.PI / 180));
const FIRST_VIEW = { yaw: 0.38, pitch: 0.1, zoom: 1, panX: 0, panY: 0 };
const camera = { ...FIRST_VIEW };

/** Matrices for a viewport, column by column. */
function matrices({ centre, radius }, aspect) {
  const [cy, sy] = [Math.cos(camera.yaw), Math.sin(camera.yaw)];
  const [cp, sp] = [Math.cos(camera.pitch), Math.sin(camera.pitch)];
  const right = [cy, sy, 0];
  const up = [-sy * sp, cy * sp, cp];
  const back = [sy * cp, -cy * cp, sp];
  const far = (radius * 1.04) / HALF_VIEW / camera.zoom + radius * 0.2;
  const offset = (axis) => -(axis[0] * centre[0] + axis[1] * centre[1] + axis[2] * centre[2]);
  const view = new Float32Array(16);
  [right, up, back].forEach((axis, row) => axis.forEach((x, k) => { view[4 * k + row] = x; }));
  view[12] = offset(right) + camera.panX * radius;
  view[13] = offset(up) + camera.panY * radius;
  view[14] = offset(back) - far;
  view[15] = 1;
  const [near, end] = [Math.max(far - 2.5 * radius, 0.01 * radius), far + 2.5 * radius];
  const projection = new Float32Array(16);
  projection[0] = 1 / HALF_VIEW / Math.max(aspect, 1);
  projection[5] = Math.min(aspect, 1) / HALF_VIEW;
  projection[10] = (end + near) / (near - end);
  projection[11] = -1;
  projection[14] = (2 * end * near) / (near - end);
  return { view, projection };
}

// ---------------------------------------------------------------------------------------------
// Colours

/** From inside the reference to outside it; two hues that every kind of colour vision tells. */
const ERROR_COLOURS = ['#14386f', '#5b9bd0', '#e6e3dc', '#e08b4a', '#8a1f10'];

const rgb = (hex) => [1, 3, 5].map((k) => parseInt(hex.slice(k, k + 2), 16) / 255);
const ERROR_STOPS = ERROR_COLOURS.map(rgb);
const themed = (name) =>
  rgb(getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim());

function errorColour(value, limit) {
  const at = (Math.min(Math.max(value / limit, -1), 1) + 1) * 2;
  const k = Math.min(Math.floor(at), 3);
  return ERROR_STOPS[k].map((x, i) => x + (ERROR_STOPS[k + 1][i] - x) * (at - k));
}

/** The end of the colours: 98 % of the values are within it, rounded up to 1, 2 or 5. */
function colourLimit(values, least) {
  const step = Math.max(1, Math.floor(values.length / 4000));
  const sample = values.filter((_, i) => i % step === 0).map(Math.abs).sort();
  const most = Math.max(sample[Math.floor(0.98 * (sample.length - 1))], least);
  if (!(most > 0)) return 0;
  const decade = 10 ** Math.floor(Math.log10(most));
  return decade * ([1, 2, 5].find((k) => k * decade >= most * 0.999) ?? 10);
}

// ---------------------------------------------------------------------------------------------
// Drawing with WebGL2

const VERTEX_SHADER = `#version 300 es
uniform mat4 view, projection;
layout(location = 0) in vec3 place;
layout(location = 1) in vec3 direction;
layout(location = 2) in float measured;
out vec3 normal, eye;
out float value;
void main() {
  vec4 seen = view * vec4(place, 1.0);
  normal = mat3(view) * direction;
  eye = -seen.xyz;
  value = measured;
  gl_Position = projection * seen;
}`;

// A hemisphere of sky and ground, a key light from the upper left, a fill, a rim from behind.
const FRAGMENT_SHADER = `#version 300 es
precision highp float;
uniform int style; // 0 lit, 1 ghost, 2 lines
uniform vec3 colour, stops[5];
uniform float limit;
in vec3 normal, eye;
in float value;
out vec4 shown;
vec3 base() {
  if (limit <= 0.0) return colour;
  float at = (clamp(value / limit, -1.0, 1.0) + 1.0) * 2.0;
  int k = min(int(at), 3);
  return mix(stops[k], stops[k + 1], at - float(k));
}
void main() {
  vec3 n = normalize(normal), v = normalize(eye);
  float edge = 1.0 - abs(dot(n, v));
  if (style == 2) { shown = vec4(colour, 1.0) * 0.42; return; }
  if (style == 1) { shown = vec4(colour, 1.0) * (0.16 + 0.6 * edge * edge); return; }
  vec3 key = normalize(vec3(-0.5, 0.62, 0.6));
  vec3 light = mix(vec3(0.13, 0.12, 0.12), vec3(0.34, 0.37, 0.42), 0.5 + 0.5 * n.y);
  light += vec3(0.92, 0.88, 0.82) * max(dot(n, key), 0.0);
  light += vec3(0.16, 0.15, 0.16) * max(dot(n, normalize(vec3(0.85, -0.05, 0.5))), 0.0);
  float rim = edge * edge * edge * smoothstep(-0.5, 0.9, n.y + 0.5 * n.x);
  float gloss = pow(max(dot(n, normalize(key + v)), 0.0), 28.0);
  vec3 lit = pow(base(), vec3(2.2)) * light;
  if (limit <= 0.0) lit += vec3(0.26, 0.29, 0.33) * rim + 0.05 * gloss;
  shown = vec4(pow(lit, vec3(1.0 / 2.2)), 1.0);
}`;

class GlRenderer {
  kind = 'webgl2';

  constructor(canvas) {
    this.gl = canvas.getContext('webgl2', { antialias: true, alpha: true });
    if (!this.gl) throw new Error('no WebGL2');
    this.restore();
  }

  /** Makes everything that the context holds; again when it was lost. */
  restore() {
    const { gl } = this;
    this.arrays = new WeakMap();
    this.indices = new WeakMap();
    const program = gl.createProgram();
    for (const [kind, source] of
      [[gl.VERTEX_SHADER, VERTEX_SHADER], [gl.FRAGMENT_SHADER, FRAGMENT_SHADER]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, source);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS) && !gl.isContextLost())
      throw new Error(gl.getProgramInfoLog(program));
    gl.useProgram(program);
    this.uniform = (name) => gl.getUniformLocation(program, name);
    gl.uniform3fv(this.uniform('stops'), ERROR_STOPS.flat());
    gl.enable(gl.DEPTH_TEST);
    gl.enable(gl.SCISSOR_TEST);
    gl.depthFunc(gl.LEQUAL);
    gl.polygonOffset(1, 2);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
  }

  draw(views, width, height) {
    const { gl } = this;
    for (const view of views) {
      const box = [view.x * width, (1 - view.y - view.height) * height,
        view.width * width, view.height * height].map(Math.round);
      gl.viewport(...box);
      gl.scissor(...box);
      gl.clearColor(0, 0, 0, 0);
      gl.depthMask(true);
      gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
      const { view: seen, projection } = matrices(view.frame, box[2] / box[3]);
      gl.uniformMatrix4fv(this.uniform('view'), false, seen);
      gl.uniformMatrix4fv(this.uniform('projection'), false, projection);
      for (const item of view.items) this.drawItem(item);
    }
  }

  drawItem({ surface: { lines, triangles }, surface: drawnOne, style, colour, limit = 0 }) {
    const { gl } = this;
    const kind = { lit: 0, ghost: 1, lines: 2 }[style];
    const indices = style === 'lines' ? lines : triangles;
    const toggle = (on, what) => (on ? gl.enable(what) : gl.disable(what));
    toggle(style !== 'lit', gl.BLEND);
    toggle(style === 'ghost', gl.CULL_FACE);
    toggle(style === 'lit', gl.POLYGON_OFFSET_FILL);
    gl.depthMask(style === 'lit');
    gl.uniform1i(this.uniform('style'), kind);
    gl.uniform3fv(this.uniform('colour'), colour);
    gl.uniform1f(this.uniform('limit'), limit);
    this.bindVertices(drawnOne);
    this.bindIndices(indices);
    const mode = style === 'lines' ? gl.LINES : gl.TRIANGLES;
    gl.drawElements(mode, indices.length, gl.UNSIGNED_INT, 0);
    gl.bindVertexArray(null);
  }

  /** Binds the vertices of a surface and sends them when they have changed. */
  bindVertices(drawnOne) {
    const { gl } = this;
    const known = this.arrays.get(drawnOne);
    const held = known ?? { array: gl.createVertexArray(), buffer: gl.createBuffer() };
    gl.bindVertexArray(held.array);
    gl.bindBuffer(gl.ARRAY_BUFFER, held.buffer);
    if (!known) {
      gl.bufferData(gl.ARRAY_BUFFER, drawnOne.vertices, gl.DYNAMIC_DRAW);
      [[3, 0], [3, 12], [1, 24]].forEach(([size, offset], k) => {
        gl.enableVertexAttribArray(k);
        gl.vertexAttribPointer(k, size, gl.FLOAT, false, STRIDE * 4, offset);
      });
      this.arrays.set(drawnOne, held);
    } else if (held.version !== drawnOne.version) {
      gl.bufferSubData(gl.ARRAY_BUFFER, 0, drawnOne.vertices);
    }
    held.version = drawnOne.version;
  }

  bindIndices(indices) {
    const { gl } = this;
    const known = this.indices.get(indices);
    const buffer = known ?? gl.createBuffer();
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, buffer);
    if (known) return;
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, indices, gl.STATIC_DRAW);
    this.indices.set(indices, buffer);
  }

  /** Waits until what was drawn is there. */
  finish() {
    const pixel = new Uint8Array(4);
    this.gl.readPixels(0, 0, 1, 1, this.gl.RGBA, this.gl.UNSIGNED_BYTE, pixel);
  }
}

// ---------------------------------------------------------------------------------------------
// Drawing without it: triangles with a buffer of depths, shaded at the vertices

class CanvasRenderer {
  kind = 'canvas';

  constructor(canvas) {
    this.context = canvas.getContext('2d');
  }

  draw(views, width, height) {
    this.context.clearRect(0, 0, width, height);
    for (const view of views) {
      const [w, h] = [Math.round(view.width * width), Math.round(view.height * height)];
      if (w < 1 || h < 1) continue;
      const image = this.context.createImageData(w, h);
      const depths = new Float32Array(w * h).fill(-Infinity);
      for (const item of view.items)
        if (item.style === 'lit') this.drawSurface(item, view.frame, image, depths);
      this.context.putImageData(image, Math.round(view.x * width), Math.round(view.y * height));
    }
  }

  drawSurface({ surface: { vertices, triangles }, colour, limit }, frame, image, depths) {
    const count = vertices.length / STRIDE;
    const { view, projection } = matrices(frame, image.width / image.height);
    const corners = new Float32Array(count * 6); // x, y and depth on the screen; colour
    for (let v = 0; v < count; v++) {
      const [px, py, pz, nx, ny, nz, value] = vertices.subarray(v * STRIDE, (v + 1) * STRIDE);
      const along = (row, x, y, z) => view[row] * x + view[4 + row] * y + view[8 + row] * z;
      const depth = along(2, px, py, pz) + view[14];
      const x = (projection[0] * (along(0, px, py, pz) + view[12])) / -depth;
      const y = (projection[5] * (along(1, px, py, pz) + view[13])) / -depth;
      const normal = [0, 1, 2].map((row) => along(row, nx, ny, nz));
      corners.set([(x + 1) * 0.5 * image.width, (1 - y) * 0.5 * image.height, depth], v * 6);
      corners.set(shade(normal, limit > 0 ? errorColour(value, limit) : colour), v * 6 + 3);
    }
    for (let t = 0; t < triangles.length; t += 3)
      fillTriangle(corners, triangles[t] * 6, triangles[t + 1] * 6, triangles[t + 2] * 6,
        image, depths);
  }

  finish() {}
}

/** The light of the shader above without rim and gloss, at one vertex. */
function shade([x, y, z], colour) {
  const key = Math.max(-0.5 * x + 0.62 * y + 0.6 * z, 0);
  const sky = 0.5 + 0.5 * y;
  return colour.map((c, k) => {
    const light = 0.12 + [0.21, 0.25, 0.3][k] * sky + [0.92, 0.88, 0.82][k] * key;
    return 255 * (c ** 2.2 * light) ** (1 / 2.2);
  });
}

function fillTriangle(corners, a, b, c, { data: pixels, width, height }, depths) {
  const [ax, ay, bx, by] = [corners[a], corners[a + 1], corners[b], corners[b + 1]];
  const [cx, cy] = [corners[c], corners[c + 1]];
  const area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax);
  if (!(Math.abs(area) > 1e-9) || Math.max(corners[a + 2], corners[b + 2], corners[c + 2]) >= 0)
    return;
  const [left, right] = [Math.max(Math.floor(Math.min(ax, bx, cx)), 0),
    Math.min(Math.ceil(Math.max(ax, bx, cx)), width - 1)];
  const [top, bottom] = [Math.max(Math.floor(Math.min(ay, by, cy)), 0),
    Math.min(Math.ceil(Math.max(ay, by, cy)), height - 1)];
  for (let y = top; y <= bottom; y++) {
    for (let x = left; x <= right; x++) {
      const v = ((x - ax) * (cy - ay) - (y - ay) * (cx - ax)) / area;
      const w = ((bx - ax) * (y - ay) - (by - ay) * (x - ax)) / area;
      const u = 1 - v - w;
      if (u < -1e-6 || v < -1e-6 || w < -1e-6) continue;
      const at = y * width + x;
      const depth = u * corners[a + 2] + v * corners[b + 2] + w * corners[c + 2];
      if (depth <= depths[at]) continue;
      depths[at] = depth;
      for (let k = 0; k < 3; k++)
        pixels[4 * at + k] = u * corners[a + 3 + k] + v * corners[b + 3 + k] + w * corners[c + 3 + k];
      pixels[4 * at + 3] = 255;
    }
  }
}

// ---------------------------------------------------------------------------------------------
// The stage: what is shown, and when it is drawn

const canvas = byId('canvas');
const shapes = namedShapes(data.shapes);
const state = { shape: shapes[0], degree: shapes[0].lmax, moving: false, shown: null, limit: 0 };
const shows = { beside: false, ghost: false, error: false, wire: false };
const timing = { asked: false, evaluate: true, measured: false, milliseconds: 0 };
let renderer;

function chooseRenderer() {
  try {
    renderer = new GlRenderer(canvas);
  } catch {
    renderer = new CanvasRenderer(canvas);
    say('No WebGL2 here: a plainer picture, without ghost and wireframe.');
  }
}

function say(text) {
  byId('status').textContent = text;
  byId('status').hidden = text === '';
}

/** Draws at the next frame; `evaluate` says that the surface has changed. */
function draw(evaluate = false) {
  timing.evaluate ||= evaluate;
  if (timing.asked) return;
  timing.asked = true;
  requestAnimationFrame(drawNow);
}

function drawNow() {
  const start = performance.now();
  timing.asked = false;
  if (timing.evaluate) evaluateShape();
  timing.evaluate = false;
  resizeCanvas();
  renderer.draw(composeViews(), canvas.width, canvas.height);
  if (timing.measured) renderer.finish();
  timing.milliseconds = performance.now() - start;
}

function resizeCanvas() {
  const most = renderer.kind === 'webgl2' ? 2 : 1;
  const density = Math.min(window.devicePixelRatio || 1, most);
  const [width, height] = [canvas.clientWidth, canvas.clientHeight]
    .map((size) => Math.max(1, Math.round(size * density)));
  if (canvas.width !== width) canvas.width = width;
  if (canvas.height !== height) canvas.height = height;
}

/** Brings the shown surface, and the scale of its colours, to the chosen degree. */
function evaluateShape() {
  const { shape, degree } = state;
  const compared = shows.error ? shape.comparison : null;
  if (compared && !compared.ready) compareLater(compared);
  const byMesh = compared?.ready ?? false;
  const quality = state.moving ? 'coarse' : 'fine';
  state.shown = byMesh ? compared.evaluate(degree) : shape.evaluate(degree, quality);
  const waiting = compared !== null && !byMesh;
  state.limit = 0;
  if (shows.error && !waiting) showLegend(byMesh);
  byId('legend').hidden = !shows.error || waiting;
}

function compareLater(compared) {
  if (compared.waiting) return;
  compared.waiting = true;
  say('Comparing with the mesh…');
  const slice = () => {
    compared.work(14);
    if (!compared.ready) return setTimeout(slice, 0);
    say('');
    draw(true);
  };
  setTimeout(slice, 0);
}

function composeViews() {
  const { shape, shown, limit } = state;
  const { frame } = shape;
  const clay = themed('clay');
  const wire = themed('wire');
  const twin = shape.mesh?.surface;
  const items = [{ surface: shown, style: 'lit', limit, colour: clay }];
  if (shows.wire) items.push({ surface: shown, style: 'lines', colour: wire });
  if (shows.ghost && twin) items.push({ surface: twin, style: 'ghost', colour: themed('ghost') });
  if (!shows.beside || !twin) return [{ x: 0, y: 0, width: 1, height: 1, frame, items }];
  const mesh = [{ surface: twin, style: 'lit', limit: 0, colour: clay }];
  if (shows.wire) mesh.push({ surface: twin, style: 'lines', colour: wire });
  const [width, height] = splitsAcross() ? [0.5, 1] : [1, 0.5];
  return [{ x: 0, y: 0, width, height, frame, items },
    { x: 1 - width, y: 1 - height, width, height, frame, items: mesh }];
}

const splitsAcross = () => canvas.clientWidth >= canvas.clientHeight;

/** Fills the legend of the error and chooses where its colours end. */
function showLegend(byMesh) {
  const { shape, degree, shown } = state;
  const values = shown.vertices.filter((_, i) => i % STRIDE === 6);
  state.limit = colourLimit(values, byMesh ? 4 * shape.mesh.step : 0);
  let [low, high] = [Infinity, -Infinity];
  for (const value of values) [low, high] = [Math.min(low, value), Math.max(high, value)];
  const [name, unit] = lengthUnit(state.limit || 1);
  const inUnit = (metres, digits) =>
    (metres > 0 ? '+' : '') + formatNumber(Number((metres / unit).toPrecision(digits)), digits);
  const end = formatNumber(Number((state.limit / unit).toPrecision(3)));
  byId('legend-low').textContent = `−${end} ${name}`;
  byId('legend-zero').textContent = '0';
  byId('legend-high').textContent = `+${end} ${name}`;
  const against = byMesh
    ? `the mesh, along its ${formatNumber(values.length)} vertices`
    : `the full series, degree ${shape.lmax}`;
  byId('legend-text').textContent = state.limit === 0
    ? `Radius at degree ${degree} equals that of ${against}`
    : `Radius at degree ${degree} less that of ${against}: `
      + `${inUnit(low, 3)} to ${inUnit(high, 3)} ${name}`;
}

// ---------------------------------------------------------------------------------------------
// The degree, and what follows it

let settling = 0;

/** Chooses a degree; `moving` draws coarsely until the hand rests. */
function setDegree(degree, moving = false) {
  state.degree = Math.min(Math.max(Math.round(degree), 0), state.shape.lmax);
  clearTimeout(settling);
  state.moving = moving;
  if (moving) settling = setTimeout(() => setDegree(state.degree), 180);
  byId('degree').value = state.degree;
  showDegree();
  draw(true);
}

function showDegree() {
  const { degree, shape } = state;
  const coefficients = `${formatNumber((degree + 1) ** 2)} coefficients`;
  byId('degree-shown').textContent = degree;
  byId('coefficients').textContent = degree === 0 ? '1 coefficient' : coefficients;
  byId('degree').setAttribute('aria-valuetext', `degree ${degree}, ${coefficients}`);
  byId('lower').disabled = degree === 0;
  byId('higher').disabled = degree === shape.lmax;
  byId('caption-series').textContent = `Degree ${degree}`;
  canvas.setAttribute('aria-label', `${shape.name} at degree ${degree} of ${shape.lmax}`);
  byId('remainder').textContent = degree === shape.lmax
    ? 'This is the full series.'
    : `The degrees above add ${formatLength(shape.remainder(degree))} RMS, `
      + `${formatNumber((100 * shape.remainder(degree)) / shape.amplitudes[0])} % of the mean radius.`;
  showCut();
  showNumbers();
  showPictures();
  markRows();
}

const rowsAt = (degree) => data.rows.filter((row) => row.degree === degree);
const measuredDegrees = [...new Set(data.rows.filter((row) => row.shape === 'series'
  && Number.isInteger(row.degree)).map((row) => row.degree))].sort((a, b) => a - b);

/** The rows of this degree beside that of the mesh, or which degrees were measured. */
function showNumbers() {
  const place = byId('numbers');
  place.hidden = data.rows.length === 0;
  if (place.hidden) return;
  const here = rowsAt(state.degree);
  if (here.length === 0) return place.replaceChildren(notMeasured());
  const mesh = data.rows.filter((row) => row.shape === 'mesh' && row.degree === null).slice(0, 1);
  const rows = [...here.slice(0, 3), ...mesh];
  const name = (row) => (row.shape === 'series' ? `Degree ${row.degree}` : row.shape);
  const columns = data.columns.filter((column) => rows.some((row) => row[column.name] != null));
  place.replaceChildren(table(['', ...rows.map(name)], columns.map((column) =>
    [column.title, ...rows.map((row) => measuredCell(row, column, true))])));
}

function notMeasured() {
  const text = element('p', {}, 'Not measured at this degree.');
  const below = measuredDegrees.findLast((degree) => degree < state.degree);
  const above = measuredDegrees.find((degree) => degree > state.degree);
  const near = [below, above].filter((degree) => degree <= state.shape.lmax);
  if (near.length > 0) text.append(' Nearest: ');
  near.forEach((degree) => text.append(degreeButton(degree), ' '));
  return text;
}

const degreeButton = (degree) => element('button',
  { type: 'button', ariaLabel: `Show degree ${degree}`, onclick: () => setDegree(degree) },
  String(degree));

/** A cell that keeps the number as it was measured, for programs that read the page. */
function measuredCell(row, column, withUnit) {
  const cell = element('td', {}, formatValue(row[column.name], column, withUnit));
  cell.dataset.shape = row.shape;
  cell.dataset.column = column.name;
  if (row[column.name] != null) cell.dataset.value = row[column.name];
  return cell;
}

/** A table of a head and rows; the first cell of a row is its head, others are text or cells. */
function table(head, rows) {
  const heads = head.map((text) => element('th', { scope: 'col' }, text));
  const body = rows.map(([first, ...rest]) => element('tr', {},
    first instanceof Node ? first : element('th', { scope: 'row' }, first),
    ...rest.map((cell) => (cell instanceof Node ? cell : element('td', {}, cell)))));
  return element('table', {}, element('thead', {}, element('tr', {}, ...heads)),
    element('tbody', {}, ...body));
}

// ---------------------------------------------------------------------------------------------
// The spectrum

const CHART = { width: 328, height: 158, left: 44, right: 8, top: 8, bottom: 24 };
const chart = { x: null, cut: null, beyond: null };

function showSpectrum() {
  const { shape: { amplitudes, lmax } } = state;
  const positive = amplitudes.filter((a) => a > 0);
  const most = positive.length > 0 ? Math.max(...positive) : 1;
  const high = Math.ceil(Math.log10(most));
  const low = Math.max(Math.floor(Math.log10(Math.min(...positive, most))), high - 9);
  const { width, height, left, right, top, bottom } = CHART;
  const span = Math.max(high - low, 1);
  const y = (a) => top + ((high - Math.max(Math.log10(a), low)) / span) * (height - top - bottom);
  chart.x = (l) => left + ((l + 0.5) / (lmax + 1)) * (width - left - right);
  const image = drawn('svg', { viewBox: `0 0 ${width} ${height}`, role: 'img' });
  image.setAttribute('aria-label', `Amplitudes of degrees 0 to ${lmax}, logarithmic`);
  const every = Math.ceil((span + 1) / 6);
  for (let decade = high; decade >= low; decade -= every) {
    const at = y(10 ** decade);
    image.append(drawn('path', { class: 'grid', d: `M${left} ${at}H${width - right}` }),
      drawn('text', { x: left - 6, y: at + 3.5, 'text-anchor': 'end' }, formatLength(10 ** decade)));
  }
  const step = [1, 2, 4, 8, 16, 32, 64, 128, 256].find((k) => lmax / k <= 8) ?? 512;
  for (let l = 0; l <= lmax; l += step)
    image.append(drawn('text', { x: chart.x(l), y: height - 6, 'text-anchor': 'middle' }, String(l)));
  for (const l of measuredDegrees.filter((degree) => degree <= lmax))
    image.append(drawn('circle', { class: 'measured', cx: chart.x(l), cy: height - 20, r: 1.4 }));
  const bar = Math.max(((width - left - right) / (lmax + 1)) * 0.68, 0.6);
  const stroke = { 'stroke-width': bar, fill: 'none' };
  chart.bars = (from, to) => Array.from({ length: Math.max(to - from, 0) }, (_, k) => from + k)
    .filter((l) => amplitudes[l] > 0)
    .map((l) => `M${chart.x(l).toFixed(2)} ${height - bottom}V${y(amplitudes[l]).toFixed(2)}`)
    .join('');
  chart.within = drawn('path', { class: 'within', ...stroke });
  chart.beyond = drawn('path', { class: 'beyond', ...stroke });
  chart.cut = drawn('path', { class: 'cut' });
  image.append(chart.within, chart.beyond, chart.cut);
  image.onpointerdown = image.onpointermove = (event) => {
    if (event.type === 'pointerdown') image.setPointerCapture(event.pointerId);
    else if (event.buttons === 0) return;
    const box = image.getBoundingClientRect();
    const place = ((event.clientX - box.left) / box.width) * width;
    setDegree(((place - left) / (width - left - right)) * (lmax + 1) - 0.5, true);
  };
  byId('spectrum').replaceChildren(image);
}

function showCut() {
  const { degree, shape: { lmax } } = state;
  const at = (chart.x(degree) + chart.x(degree + 1)) / 2;
  chart.within.setAttribute('d', chart.bars(0, degree + 1));
  chart.beyond.setAttribute('d', chart.bars(degree + 1, lmax + 1));
  chart.cut.setAttribute('d', `M${at} ${CHART.top}V${CHART.height - CHART.bottom}`);
}

// ---------------------------------------------------------------------------------------------
// Pictures, plots, answers, rows

const isPicture = (text) => typeof text === 'string' && text.startsWith('data:image/');
const pictured = data.pictures.filter((entry) => entry.degree !== null && isPicture(entry.picture));
const picturedMesh = data.pictures.find((entry) => entry.degree === null);

/** The pictures of the nearest degree that has one, of the mesh, and of their difference. */
function showPictures() {
  byId('pictures').hidden = !data.pictures.some((entry) => isPicture(entry.picture));
  if (byId('pictures').hidden) return;
  const away = (entry) => Math.abs(entry.degree - state.degree);
  const near = pictured.reduce((a, b) => (a && away(a) <= away(b) ? a : b), null);
  const list = [];
  if (near) list.push([near.picture, `Degree ${near.degree}`]);
  if (isPicture(picturedMesh?.picture)) list.push([picturedMesh.picture, 'The mesh itself']);
  if (isPicture(near?.difference)) list.push([near.difference, `Difference at degree ${near.degree}`]);
  byId('pictures-text').textContent = near && near.degree !== state.degree
    ? `No picture of degree ${state.degree}; the nearest is of degree ${near.degree}.` : '';
  const place = byId('pictures-list');
  const shown = [...place.querySelectorAll('img')].map((image) => image.src);
  if (list.length === shown.length && list.every(([source], i) => source === shown[i])) return;
  place.replaceChildren(...list.map(([source, text]) => figure(source, text)));
}

const figure = (source, text) => element('figure', {}, element('img', { src: source, alt: text }),
  element('figcaption', {}, text));

/** An image of SVG text runs no script and loads nothing. */
function svgSource(text) {
  const bytes = new TextEncoder().encode(text);
  let binary = '';
  for (let at = 0; at < bytes.length; at += 8192)
    binary += String.fromCharCode(...bytes.subarray(at, at + 8192));
  return `data:image/svg+xml;base64,${btoa(binary)}`;
}

function showPlots() {
  byId('plots').hidden = data.plots.length === 0;
  byId('plots-list').replaceChildren(...data.plots.map((plot) =>
    figure(svgSource(plot.svg), plot.name)));
}

const KNOWN_ANSWERS = {
  tolerance: 'Tolerance', degree: 'Degree', bytes: 'Bytes', nanoseconds_per_ray: 'ns per ray',
};

function showAnswers() {
  byId('answers').hidden = data.answers.length === 0;
  const keys = [...new Set(['tolerance', 'degree', ...data.answers.flatMap(Object.keys)])];
  const head = keys.map((key) => KNOWN_ANSWERS[key] ?? key.replaceAll('_', ' '));
  byId('answers-table').replaceChildren(table(head, data.answers.map((answer) =>
    keys.map((key) => answerCell(key, answer[key])))));
}

function answerCell(key, value) {
  if (key !== 'degree') return formatValue(value, {}, false);
  if (value === null || value === undefined) return 'none measured';
  return element('td', {}, degreeButton(value));
}

function showRows() {
  byId('rows').hidden = data.rows.length === 0;
  const head = ['Shape', 'Degree', ...data.columns.map(({ title, unit }) =>
    (unit ? `${title}, ${unit}` : title))];
  const made = table(head, data.rows.map((row) => [
    String(row.shape),
    row.degree == null ? '–' : element('td', {}, degreeButton(row.degree)),
    ...data.columns.map((column) => measuredCell(row, column, false)),
  ]));
  made.querySelectorAll('tbody tr').forEach((tr, i) => { tr.dataset.degree = data.rows[i].degree; });
  byId('rows-table').replaceChildren(made);
}

function markRows() {
  for (const row of byId('rows-table').querySelectorAll('tbody tr'))
    row.classList.toggle('chosen', row.dataset.degree === String(state.degree));
}

// ---------------------------------------------------------------------------------------------
// Shapes and switches

function showShape(index) {
  state.shape = shapes[index];
  const { shape } = state;
  byId('degree').max = shape.lmax;
  byId('shape').value = index;
  for (const id of ['beside', 'ghost']) {
    byId(id).disabled = !shape.mesh || (id === 'ghost' && renderer.kind !== 'webgl2');
    byId(id).title = shape.mesh ? '' : 'This page holds no mesh of the shape';
  }
  byId('wire').disabled = renderer.kind !== 'webgl2';
  byId('facts').textContent = facts(shape);
  byId('caption-mesh').textContent = shape.mesh
    ? `Mesh, ${formatNumber(shape.mesh.faces)} triangles` : '';
  showSpectrum();
  showSwitches();
  setDegree(Math.min(state.degree, shape.lmax));
}

function facts({ spec, mesh, amplitudes, lmax }) {
  const parts = [`Mean radius ${formatLength(amplitudes[0])}, series to degree ${lmax}`];
  if (spec.source) parts.push(`from ${spec.source}`);
  const text = [parts.join(', ')];
  text.push(`Radii are from (${spec.centre.map((x) => formatNumber(x)).join(', ')}) m`);
  if (mesh && mesh.facesOfOriginal > mesh.faces) {
    text.push(`The mesh here is thinned: ${formatNumber(mesh.faces)} of `
      + `${formatNumber(mesh.facesOfOriginal)} triangles`);
  }
  return `${text.join('. ')}.`;
}

function showSwitches() {
  for (const id of Object.keys(shows)) byId(id).setAttribute('aria-pressed', shows[id]);
  const split = shows.beside && state.shape.mesh !== null;
  byId('caption-mesh').hidden = !split;
  byId('captions').classList.toggle('columns', split && splitsAcross());
  byId('captions').classList.toggle('rows', split && !splitsAcross());
}

function toggle(id) {
  if (byId(id).disabled) return;
  shows[id] = !shows[id];
  if (id === 'error' && !shows.error && renderer.kind === 'webgl2') say('');
  showSwitches();
  draw(id === 'error');
}

// ---------------------------------------------------------------------------------------------
// Mouse, fingers, keys

function turn(yaw, pitch) {
  camera.yaw -= yaw;
  camera.pitch = Math.min(Math.max(camera.pitch + pitch, -1.57), 1.57);
  draw();
}

function zoom(factor) {
  camera.zoom = Math.min(Math.max(camera.zoom * factor, 0.3), 12);
  draw();
}

/** Moves by pixels, as far as the surface moves under the hand. */
function pan(x, y) {
  const across = Math.min(canvas.clientWidth, canvas.clientHeight);
  camera.panX += (2.2 * x) / across / camera.zoom;
  camera.panY -= (2.2 * y) / across / camera.zoom;
  draw();
}

/** Goes back to the first view, at once where motion is not wanted. */
function firstView() {
  const from = { ...camera };
  const start = performance.now();
  const still = matchMedia('(prefers-reduced-motion: reduce)').matches;
  const step = () => {
    const t = still ? 1 : Math.min((performance.now() - start) / 280, 1);
    const eased = t * t * (3 - 2 * t);
    for (const key of Object.keys(camera))
      camera[key] = from[key] + (FIRST_VIEW[key] - from[key]) * eased;
    draw();
    if (t < 1) requestAnimationFrame(step);
  };
  step();
}

function listenToPointers() {
  const held = new Map();
  const spread = () => {
    const [a, b] = [...held.values()];
    return { x: (a.x + b.x) / 2, y: (a.y + b.y) / 2, size: Math.hypot(a.x - b.x, a.y - b.y) || 1 };
  };
  canvas.addEventListener('pointerdown', (event) => {
    canvas.setPointerCapture(event.pointerId);
    held.set(event.pointerId, { x: event.clientX, y: event.clientY });
  });
  canvas.addEventListener('pointermove', (event) => {
    const last = held.get(event.pointerId);
    if (!last) return;
    const before = held.size === 2 ? spread() : null;
    held.set(event.pointerId, { x: event.clientX, y: event.clientY });
    const [x, y] = [event.clientX - last.x, event.clientY - last.y];
    if (before) {
      const after = spread();
      pan(after.x - before.x, after.y - before.y);
      zoom(after.size / before.size);
    } else if (event.buttons > 1 || event.shiftKey) pan(x, y);
    else turn(x * 0.008, y * 0.008);
  });
  for (const name of ['pointerup', 'pointercancel'])
    canvas.addEventListener(name, (event) => held.delete(event.pointerId));
  canvas.addEventListener('wheel', (event) => {
    event.preventDefault();
    zoom(Math.exp(-event.deltaY * [0.0015, 0.04, 0.5][event.deltaMode]));
  }, { passive: false });
  canvas.addEventListener('contextmenu', (event) => event.preventDefault());
  canvas.addEventListener('dblclick', firstView);
}

const KEYS_ANYWHERE = {
  '[': () => setDegree(state.degree - 1, true),
  ']': () => setDegree(state.degree + 1, true),
  m: () => toggle('beside'),
  g: () => toggle('ghost'),
  e: () => toggle('error'),
  w: () => toggle('wire'),
  r: firstView,
};
const KEYS_ON_STAGE = {
  ArrowLeft: () => turn(-0.09, 0),
  ArrowRight: () => turn(0.09, 0),
  ArrowUp: () => turn(0, -0.09),
  ArrowDown: () => turn(0, 0.09),
  '+': () => zoom(1.12),
  '=': () => zoom(1.12),
  '-': () => zoom(1 / 1.12),
  PageUp: () => setDegree(state.degree + 1, true),
  PageDown: () => setDegree(state.degree - 1, true),
};

function listenToKeys() {
  document.addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey || event.target.closest('select')) return;
    const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
    const act = (event.target === canvas ? KEYS_ON_STAGE[key] : undefined) ?? KEYS_ANYWHERE[key];
    if (!act) return;
    event.preventDefault();
    act();
  });
}

function listenToControls() {
  byId('degree').addEventListener('input', (event) => setDegree(event.target.valueAsNumber, true));
  byId('lower').addEventListener('click', () => setDegree(state.degree - 1));
  byId('higher').addEventListener('click', () => setDegree(state.degree + 1));
  byId('shape').addEventListener('change', (event) => showShape(Number(event.target.value)));
  for (const id of Object.keys(shows)) byId(id).addEventListener('click', () => toggle(id));
  new ResizeObserver(() => { showSwitches(); draw(); }).observe(canvas);
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => draw());
  canvas.addEventListener('webglcontextlost', (event) => event.preventDefault());
  canvas.addEventListener('webglcontextrestored', () => { renderer.restore(); draw(); });
}

// ---------------------------------------------------------------------------------------------
// Start

function start() {
  byId('title').textContent = data.title;
  byId('note').textContent = data.note ?? '';
  byId('note').hidden = !data.note;
  byId('software').textContent = data.software;
  byId('legend-bar').style.background = `linear-gradient(to right, ${ERROR_COLOURS.join(', ')})`;
  byId('chooser').hidden = shapes.length < 2;
  byId('shape').append(...shapes.map((shape, i) => element('option', { value: i }, shape.name)));
  chooseRenderer();
  showPlots();
  showAnswers();
  showRows();
  listenToPointers();
  listenToKeys();
  listenToControls();
  showShape(0);
  drawNow();
}

/** For tests and for the console. */
window.harmolux = {
  ready: false,
  degree: () => state.degree,
  setDegree: (degree) => setDegree(degree),
  /** The radius, metres, of a shape by its number, at a degree, along a unit direction. */
  radius(shape, degree, direction) {
    const { series } = shapes[shape];
    return series.radii(direction, new Float64Array(series.lmax + 1))[degree];
  },
  renderer: () => renderer.kind,
  /** Whether drawing waits for its end, so that its time is that of the whole. */
  measure: (on) => { timing.measured = on; },
  get drawMilliseconds() { return timing.milliseconds; },
};

start();
window.harmolux.ready = true;
})();
