// Cells painted black or white, and the text that they are kept and sent as: four cells a hexadecimal digit, row 0 first.

/** The cells (true: a wall) that a text stands for, or null where it is not one of `count` cells. */
export function fromText(text, count) {
  if (typeof text !== "string" || text.length * 4 !== count || !/^[0-9a-f]*$/.test(text)) return null;
  return [...text].flatMap((digit) => [8, 4, 2, 1].map((bit) => (parseInt(digit, 16) & bit) > 0));
}

export function toText(cells) {
  let text = "";
  for (let k = 0; k < cells.length; k += 4) {
    text += (8 * cells[k] + 4 * cells[k + 1] + 2 * cells[k + 2] + 1 * cells[k + 3]).toString(16);
  }
  return text;
}

/** The cells that a line between two cells goes through, so that a quick hand leaves no hole. */
export function between([column, row], [toColumn, toRow]) {
  const steps = Math.max(Math.abs(toColumn - column), Math.abs(toRow - row), 1);
  return Array.from({ length: steps + 1 }, (_, k) => [
    Math.round(column + ((toColumn - column) * k) / steps),
    Math.round(row + ((toRow - row) * k) / steps),
  ]);
}
