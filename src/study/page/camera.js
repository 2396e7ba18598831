// The camera, z up and at first from -y towards +y, and the colours.

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
  const far = (radius * 1.1) / HALF_VIEW;
  const offset = (axis) => -(axis[0] * centre[0] + axis[1] * centre[1] + axis[2] * centre[2]);
  const view = new Float32Array(16);
  [right, up, back].forEach((axis, row) => axis.forEach((x, k) => { view[4 * k + row] = x; }));
  view[12] = offset(right) + camera.panX * radius;
  view[13] = offset(up) + camera.panY * radius;
  view[14] = offset(back) - far;
  view[15] = 1;
  const [near, end] = [far - 2.5 * radius, far + 2.5 * radius];
  const projection = new Float32Array(16);
  projection[0] = camera.zoom / HALF_VIEW / Math.max(aspect, 1);
  projection[5] = (camera.zoom * Math.min(aspect, 1)) / HALF_VIEW;
  projection[10] = (end + near) / (near - end);
  projection[11] = -1;
  projection[14] = (2 * end * near) / (near - end);
  return { view, projection };
}

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
