// The chosen degree, its numbers and the spectrum.

/** Chooses a degree; `moving` while a hand goes over many. */
function setDegree(degree, moving = false) {
  state.degree = Math.min(Math.max(Math.round(degree), 0), state.shape.lmax);
  byId('degree').value = state.degree;
  showDegree();
  if (moving) drawMoving(true);
  else draw(true);
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
  const above = shape.remainder(degree);
  byId('remainder').textContent = degree === shape.lmax ? 'This is the full series.'
    : `The degrees above add ${formatLength(above)} RMS, `
      + `${formatNumber((100 * above) / shape.amplitudes[0])} % of the mean radius.`;
  showCut();
  showNumbers();
  showPictures();
  markRows();
}

const measuredDegrees = [...new Set(data.rows.filter((row) => row.shape === 'series'
  && Number.isInteger(row.degree)).map((row) => row.degree))].sort((a, b) => a - b);
const meshRow = data.rows.find((row) => row.shape === 'original');
const shownColumns = data.columns.filter((column) => !column.detail
  && data.rows.some((row) => row.shape === 'series' && row[column.name] != null));

/** What was measured at this degree beside the mesh; as high whether it was or not. */
function showNumbers() {
  const place = byId('numbers');
  place.hidden = measuredDegrees.length === 0;
  if (place.hidden) return;
  const { degree } = state;
  const here = data.rows.find((row) => row.shape === 'series' && row.degree === degree);
  const rows = [here ?? { shape: 'series' }, ...(meshRow ? [meshRow] : [])];
  const head = ['', `Degree ${degree}`, ...(meshRow ? [state.shape.mesh ? 'Mesh' : 'Whole'] : [])];
  const text = element('p', {}, here ? 'Measured at this degree' : 'Not measured at this degree');
  const below = measuredDegrees.findLast((other) => other < degree);
  const above = measuredDegrees.find((other) => other > degree && other <= state.shape.lmax);
  if (below !== undefined) text.append(' ', degreeButton(below, `← ${below}`));
  if (above !== undefined) text.append(' ', degreeButton(above, `${above} →`));
  place.replaceChildren(table(head, shownColumns.map((column) =>
    [column.title, ...rows.map((row) => measuredCell(row, column, true))])), text);
}

const degreeButton = (degree, text = String(degree)) => element('button',
  { type: 'button', ariaLabel: `Show degree ${degree}`, onclick: () => setDegree(degree) }, text);

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

const CHART = { width: 328, height: 158, left: 52, right: 8, top: 8, bottom: 24 };
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
    const label = { x: left - 6, y: at + 3.5, 'text-anchor': 'end' };
    image.append(drawn('path', { class: 'grid', d: `M${left} ${at}H${width - right}` }),
      drawn('text', label, formatLength(10 ** decade)));
  }
  const step = [1, 2, 4, 8, 16, 32, 64, 128, 256].find((k) => lmax / k <= 8) ?? 512;
  for (let l = 0; l <= lmax; l += step) {
    const label = { x: chart.x(l), y: height - 6, 'text-anchor': 'middle' };
    image.append(drawn('text', label, String(l)));
  }
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
