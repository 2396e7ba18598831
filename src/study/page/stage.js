// The stage: what is shown, when it is drawn, the legend of the error.

const canvas = byId('canvas');
const shapes = namedShapes(data.shapes);
const state = { shape: shapes[0], degree: shapes[0].lmax, moving: false, shown: null, limit: 0 };
const shows = { beside: false, ghost: false, error: false, wire: false };
const timing = { asked: false, since: 0, evaluate: true, measured: false, milliseconds: 0 };
const PLAIN = 'No WebGL2 here: a plainer picture, without ghost and wireframe.';
let renderer;

function chooseRenderer() {
  try {
    renderer = new GlRenderer(canvas);
  } catch {
    renderer = new CanvasRenderer(canvas);
    say();
  }
}

/** Says what is going on, or what always holds. */
function say(text = renderer.kind === 'webgl2' ? '' : PLAIN) {
  byId('status').textContent = text;
  byId('status').hidden = text === '';
}

let settling = 0;

/** Draws while a hand moves: coarsely where drawing is slow, until the hand rests. */
function drawMoving(evaluate = false) {
  const began = !state.moving;
  state.moving = true;
  clearTimeout(settling);
  settling = setTimeout(() => {
    state.moving = false;
    draw(true);
  }, 180);
  draw(evaluate || (began && renderer.slow));
}

/** Draws at the next frame; `evaluate` says that the surface has changed. */
function draw(evaluate = false) {
  timing.evaluate ||= evaluate;
  if (timing.asked) return;
  timing.asked = true;
  timing.since = performance.now();
  requestAnimationFrame(drawNow);
}

function drawNow() {
  timing.asked = false;
  if (timing.evaluate) evaluateShape();
  timing.evaluate = false;
  resizeCanvas();
  renderer.draw(composeViews(), canvas.width, canvas.height);
  if (timing.measured) renderer.finish();
  timing.milliseconds = performance.now() - timing.since;
}

function resizeCanvas() {
  const sharp = Math.min(window.devicePixelRatio || 1, renderer.slow ? 1 : 2);
  const density = state.moving && renderer.slow ? 0.6 * sharp : sharp;
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
  const quality = state.moving && (renderer.slow || shape.lmax > 100) ? 'coarse' : 'fine';
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
    say();
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

const splitsAcross = () => canvas.clientWidth * 1.3 >= canvas.clientHeight;

/** Fills the legend of the error and chooses where its colours end. */
function showLegend(byMesh) {
  const { shape, degree, shown } = state;
  const values = valuesOf(shown);
  state.limit = colourLimit(values, byMesh ? 4 * shape.mesh.step : 0);
  let [low, high] = [Infinity, -Infinity];
  for (const value of values) [low, high] = [Math.min(low, value), Math.max(high, value)];
  const [name, unit] = lengthUnit(state.limit || 1);
  const inUnit = (metres, digits) =>
    (metres > 0 ? '+' : '') + formatNumber(Number((metres / unit).toPrecision(digits)), digits);
  const end = formatNumber(Number((state.limit / unit).toPrecision(3)));
  const ends = state.limit > 0 ? [`−${end} ${name}`, `+${end} ${name}`] : ['', ''];
  [byId('legend-low').textContent, byId('legend-high').textContent] = ends;
  const against = byMesh
    ? `the mesh, along its ${formatNumber(values.length)} vertices`
    : `the full series, degree ${shape.lmax}`;
  byId('legend-text').textContent = state.limit === 0
    ? `Radius at degree ${degree} equals that of ${against}`
    : `Radius at degree ${degree} less that of ${against}: `
      + `${inUnit(low, 3)} to ${inUnit(high, 3)} ${name}`;
}
