// An array of numbers as a picture: a cell each, or a bar each in one dimension, with those that have changed outlined.

import { exact, french } from "./numbers.js";
import { drawn } from "./svg.js";
import { counted, shape } from "./words.js";

const LEAST = 9; // numbers, for a picture to say more than they do
const LEAST_SIDE = 5; // of two dimensions: fewer columns are rather the coordinates of points
const [WIDE, TALL] = [288, 56];
const MOST_SIDE = 14; // pixels of a cell

/** « 3 cases changées ». */
export function changedCells(count) {
  return `${counted(count, "case")} changée${count > 1 ? "s" : ""}`;
}

/** A picture, or null where there is nothing to see in one. */
export function picture(value, entries) {
  const { shape: sizes, values, cut } = value;
  const numbers = values.map((one) => (one === "True" ? 1 : one === "False" ? 0 : Number(one)));
  if (sizes.length > 2 || numbers.length < LEAST || !numbers.some(Number.isFinite)) return null;
  if (sizes.length === 2 && Math.min(...sizes) < LEAST_SIDE) return null;
  const finite = numbers.filter(Number.isFinite);
  const [low, high] = [Math.min(...finite), Math.max(...finite)];
  const range = `de ${french(String(low))} à ${french(String(high))}`;
  const marks = entries.length > 0 ? ` ; ${changedCells(entries.length)}` : "";
  const label = `Dessin du tableau ${sizes.length === 2 ? shape(value) : `de ${counted(sizes[0], "valeur")}`}, ${range}${cut ? " ; le début seulement" : ""}${marks}`;
  const paint = sizes.length === 2 ? cells : bars;
  return paint(numbers, values, sizes, new Set(entries), { low, high, label });
}

function cells(numbers, values, [, columns], changed, { low, high, label }) {
  const rows = Math.ceil(numbers.length / columns);
  const side = Math.min(MOST_SIDE, WIDE / columns);
  const greatest = Math.max(Math.abs(low), Math.abs(high)) || 1;
  const parts = numbers.map((number, k) => {
    const [row, column] = [Math.floor(k / columns), k % columns];
    const strength = Number.isFinite(number) ? Math.abs(number) / greatest : 1;
    const look = Number.isFinite(number) ? (number < 0 ? "steps-cell-minus" : "steps-cell-plus") : "steps-cell-none";
    const box = { x: column * side, y: row * side, width: side, height: side };
    const cell = drawn("rect", { ...box, class: `steps-cell ${look}`, "fill-opacity": strength === 0 ? 0 : 0.12 + 0.88 * strength }, title(`[${row}, ${column}] : ${exact(values[k])}`));
    return [cell, changed.has(k) ? drawn("rect", { ...inset(box, 1), class: "steps-cell-changed" }) : null];
  });
  return framed(columns * side, rows * side, label, [...parts.map(([cell]) => cell), ...parts.flatMap(([, mark]) => mark ?? [])]);
}

function bars(numbers, values, _sizes, changed, { low, high, label }) {
  const [bottom, top] = [Math.min(low, 0), Math.max(high, 0)];
  const y = (number) => (TALL - 4) * (1 - (number - bottom) / (top - bottom || 1)) + 2;
  const wide = WIDE / numbers.length;
  const parts = numbers.map((number, k) => {
    const [from, to] = Number.isFinite(number) ? [y(Math.max(number, 0)), y(Math.min(number, 0))] : [0, TALL];
    const look = !Number.isFinite(number) ? "steps-cell-none" : number < 0 ? "steps-cell-minus" : "steps-cell-plus";
    const box = { x: k * wide, y: from, width: Math.max(1, wide - 1), height: Math.max(1, to - from) };
    return drawn("rect", { ...box, class: `steps-bar ${look}${changed.has(k) ? " steps-bar-changed" : ""}` }, title(`[${k}] : ${exact(values[k])}`));
  });
  return framed(WIDE, TALL, label, parts);
}

function framed(width, height, label, parts) {
  return drawn("svg", { viewBox: `0 0 ${width} ${height}`, style: `max-width: ${width}px`, class: "steps-picture", role: "img", "aria-label": label }, ...parts);
}

function inset({ x, y, width, height }, by) {
  return { x: x + by, y: y + by, width: Math.max(1, width - 2 * by), height: Math.max(1, height - 2 * by) };
}

function title(text) {
  return drawn("title", {}, text);
}
