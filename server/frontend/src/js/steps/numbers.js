// Numbers as a French reader writes them: those of a verdict are written alike (graders/core/compare/words.py).

const MINUS = "−";
const RAISED = "⁰¹²³⁴⁵⁶⁷⁸⁹";
const DIGITS = 6;
const NUMERIC = /^(u?int|float|complex|c?longdouble)/;
const MOST_DIGITS = 15; // of an integer that is written whole
const BEYOND = new Map([["nan", "nan"], ["inf", "∞"], ["-inf", `${MINUS}∞`]]);

/** A number that Python has written, in French: at most `digits` significant digits, π/2 by its name. */
export function french(text, digits = DIGITS) {
  if (BEYOND.has(text)) return BEYOND.get(text);
  if (/^-?\d+$/.test(text)) return integer(text, digits);
  const value = Number(text);
  if (Number.isNaN(value)) return exact(text); // a complex number, or one of which but the size is told
  return partOfPi(value) ?? (value === 0 ? "0" : rounded(value, digits));
}

/** All its digits, with a decimal comma. */
export function exact(text) {
  return BEYOND.get(text) ?? text.replace(/10\^(\d+)/, (_, power) => `10${raised(power)}`).replaceAll("-", MINUS).replaceAll(".", ",");
}

/** An item of an array, which is not always a number. */
export function itemOf(text, { dtype }, greatest, digits = DIGITS) {
  return NUMERIC.test(dtype) ? inArray(text, greatest, digits) : text;
}

/** The same with all its digits. */
export function exactItem(text, { dtype }) {
  return NUMERIC.test(dtype) ? exact(text) : text;
}

/** `french`, in an array whose greatest number is `greatest`: what is only the dust of rounding beside it says so. */
export function inArray(text, greatest, digits = DIGITS) {
  const value = Number(text);
  return value !== 0 && Math.abs(value) < 1e-13 * greatest ? "≈\u202f0" : french(text, digits);
}

function integer(text, digits) {
  const size = text.replace("-", "").length;
  if (size <= MOST_DIGITS) return text.replace("-", MINUS);
  return size > 300 ? `${text.startsWith("-") ? MINUS : ""}environ 10${raised(size - 1)}` : rounded(Number(text), digits);
}

/** As Python's format « g ». */
function rounded(value, digits) {
  const [mantissa, exponent] = value.toExponential(digits - 1).split("e");
  const power = Number(exponent);
  const plain = power >= -4 && power < digits;
  const written = trimmed(plain ? value.toFixed(digits - 1 - power) : mantissa).replace("-", MINUS).replace(".", ",");
  return plain ? written : `${written}\u00a0×\u00a010${raised(power)}`;
}

function trimmed(text) {
  return text.includes(".") ? text.replace(/\.?0+$/, "") : text;
}

function raised(power) {
  return String(power).replace("-", "⁻").replace(/\d/g, (digit) => RAISED[digit]);
}

/** « π/2 » rather than 1,5708: only for simple fractions, exact to rounding. */
function partOfPi(value) {
  if (Math.abs(value) > 12 * Math.PI) return null;
  for (const below of [1, 2, 3, 4, 6]) {
    const multiple = (value * below) / Math.PI;
    const times = Math.round(multiple);
    if (times === 0 || Math.abs(times) >= 12 || Math.abs(multiple - times) >= 1e-12) continue;
    const top = Math.abs(times) === 1 ? "π" : `${Math.abs(times)}π`;
    return `${times < 0 ? MINUS : ""}${top}${below > 1 ? `/${below}` : ""}`;
  }
  return null;
}
