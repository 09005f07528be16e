// What of a program's variables may be a drawing: points of the plane, and poses. Which of them is one is a guess by its
// name, which the reader may change.

const MOST = 400; // points
const FARTHEST = 1e9;
const POSES = /pose|robot|particul|[ée]tat|traj|estim|v[ée]rit|^[abcxz][ijk01]?$|^x_?\d$/i;
const POINTS = /point|pos|amer|centre|bary|but|cible|mur|^[pqt]\d?$|^xy/i;
const LARGEST_ANGLE = 4 * Math.PI;

/** Rows of two or three numbers, or null: an array n × 2 or n × 3, a list of such rows, or one alone. */
export function rowsOf(value) {
  const rows = value.kind === "array" ? arrayRows(value) : value.kind === "sequence" ? listRows(value) : null;
  return rows && rows.length > 0 && rows.length <= MOST && rows.flat().every((one) => Math.abs(one) < FARTHEST) ? rows : null;
}

/** Of an array that is cut, the first rows. */
function arrayRows({ shape, values, dtype }) {
  if (dtype === "bool" || ![2, 3].includes(shape.at(-1)) || shape.length > 2) return null;
  const numbers = values.map(Number);
  const wide = shape.at(-1);
  return Array.from({ length: Math.floor(numbers.length / wide) }, (_, k) => numbers.slice(wide * k, wide * (k + 1)));
}

function listRows({ items, length, type }) {
  if (!["list", "tuple"].includes(type) || items.length < length) return null;
  if (items.every((one) => one.kind === "number")) return [2, 3].includes(length) ? [items.map((one) => Number(one.text))] : null;
  const rows = items.map((one) => (one.kind === "array" && one.shape.length === 1 ? arrayRows(one)?.[0] : one.kind === "sequence" ? listRows(one)?.[0] : null));
  return rows.every((row) => row && row.length === rows[0].length) ? rows : null;
}

/** What a variable may be drawn as, and what it is taken for: {offered: ["points", "poses"], guess: one of them or ""}; null for what is no drawing. */
export function drawable(name, value) {
  const rows = rowsOf(value);
  if (!rows) return null;
  const alone = value.kind === "array" ? value.shape.length === 1 : rows.length === 1 && value.items.every((one) => one.kind === "number");
  if (rows[0].length === 2) {
    // two by two may as well be a rotation, and whole numbers be rows and columns of a map
    const doubtful = value.kind === "array" && (/int/.test(value.dtype) || (value.shape.length === 2 && value.shape[0] === 2));
    return { offered: ["points"], guess: POINTS.test(name) || (!alone && !doubtful) ? "points" : "" };
  }
  const turns = rows.every((row) => Math.abs(row[2]) <= LARGEST_ANGLE);
  const matrix = value.kind === "array" && value.shape.length === 2 && value.shape[0] === 3 && !/pose|particul|traj/i.test(name);
  return { offered: ["poses", "points"], guess: POSES.test(name) && turns && !matrix ? "poses" : "" };
}
