// Shapes and switches, mouse, fingers, keys; the start of the page.

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
  showSwitches();
  draw(id === 'error');
}

function turn(yaw, pitch) {
  camera.yaw -= yaw;
  camera.pitch = Math.min(Math.max(camera.pitch + pitch, -1.57), 1.57);
  drawMoving();
}

function zoom(factor) {
  camera.zoom = Math.min(Math.max(camera.zoom * factor, 0.3), 12);
  drawMoving();
}

/** Moves by pixels, as far as the surface moves under the hand. */
function pan(x, y) {
  const across = Math.min(canvas.clientWidth, canvas.clientHeight);
  camera.panX += (2.2 * x) / across / camera.zoom;
  camera.panY -= (2.2 * y) / across / camera.zoom;
  drawMoving();
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

function start() {
  byId('title').textContent = data.title;
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
  timing.since = performance.now();
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
  /** From the last wish to draw until it was drawn, the wait for the frame included. */
  get drawMilliseconds() { return timing.milliseconds; },
};

start();
window.harmolux.ready = true;
