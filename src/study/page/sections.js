// Pictures, plots, answers and the table of all rows.

const isPicture = (text) => typeof text === 'string' && text.startsWith('data:image/');
const pictured = data.pictures.filter((entry) => entry.degree != null && isPicture(entry.picture));
const picturedMesh = data.pictures.find((entry) => entry.degree == null);

/** The pictures of the nearest degree that has one, of the mesh, and of their difference. */
function showPictures() {
  byId('pictures').hidden = !data.pictures.some((entry) => isPicture(entry.picture));
  if (byId('pictures').hidden) return;
  const away = (entry) => Math.abs(entry.degree - state.degree);
  const near = pictured.reduce((a, b) => (a && away(a) <= away(b) ? a : b), null);
  const list = [];
  if (near) list.push([near.picture, `Degree ${near.degree}`]);
  if (isPicture(picturedMesh?.picture)) list.push([picturedMesh.picture, 'The mesh itself']);
  if (isPicture(near?.difference))
    list.push([near.difference, `Difference at degree ${near.degree}`]);
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

const headOf = ({ title, unit }) =>
  (unit && unit.toLowerCase() !== title.toLowerCase() ? `${title}, ${UNITS[unit] ?? unit}` : title);

function showRows() {
  byId('rows').hidden = data.rows.length === 0;
  const head = ['Shape', 'Degree', ...data.columns.map(headOf)];
  const made = table(head, data.rows.map((row) => [
    String(row.shape),
    row.degree == null ? '–' : element('td', {}, degreeButton(row.degree)),
    ...data.columns.map((column) => measuredCell(row, column, false)),
  ]));
  made.querySelectorAll('tbody tr')
    .forEach((row, i) => { row.dataset.degree = data.rows[i].degree; });
  byId('rows-table').replaceChildren(made);
}

function markRows() {
  for (const row of byId('rows-table').querySelectorAll('tbody tr'))
    row.classList.toggle('chosen', row.dataset.degree === String(state.degree));
}
