// The data of the page, elements, and numbers in words. Names come from files of others: text is
// set as text, elements are made one by one. Lengths are metres.

const data = JSON.parse(document.getElementById('data').textContent);
for (const list of ['columns', 'rows', 'pictures', 'plots', 'answers']) data[list] ??= [];

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
  const [inUnit, whole] = [metres / unit, Math.round(metres / unit)];
  const value = Math.abs(inUnit - whole) < 1e-9 * whole ? whole : inUnit;
  return `${formatNumber(value, digits)} ${name}`;
}

const UNITS = { bytes: 'B', deg: '°' };

/** Writes a measured value; `unit` is empty where the head of the table bears it. */
function formatValue(value, column, withUnit) {
  if (value === null || value === undefined) return '–';
  if (typeof value !== 'number') return String(value);
  const scaled = value * (column.scale ?? 1);
  if (!withUnit) return formatNumber(scaled);
  if (column.unit === 'm') return formatLength(scaled);
  const unit = UNITS[column.unit] ?? column.unit ?? '';
  return unit === '' ? formatNumber(scaled) : `${formatNumber(scaled)} ${unit}`;
}
