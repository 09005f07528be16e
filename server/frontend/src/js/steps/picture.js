// An array of numbers as a picture: a cell each, or a bar each in one dimension, with those that have changed outlined.

import { exact, french } from "./numbers.js";
import { drawn } from "./svg.js";
import { counted, shape } from "./words.js";

const LEAST = 9; // numbers, for a picture to say more than they do
const LEAST_SIDE = 5; // of two dimensions: fewer columns are rather the coordinates of points
const [WIDE, TALL] = [288, 56];
const MOST_SIDE = 14; // pixels of a cell
const LEVELS = 10; // of its ink

/** « 3 cases changées ». */
export function changedCells(count) {
  return `${counted(count, "case")} changée${count > 1 ? "s" : ""}`;
}

const drawnBefore = new WeakMap(); // of values that have not just changed: most stay as they are from step to step

/** A picture, or null where there is nothing to see in one. */
export function picture(value, entries) {
  if (entries.length > 0) return made(value, entries);
  if (!drawnBefore.has(value)) drawnBefore.set(value, made(value, entries));
  return drawnBefore.get(value);
}

function made(value, entries) {
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

/** A path for each strength and sign, and not an element for each cell: programs hold many arrays. */
function cells(numbers, values, [, columns], changed, { low, high, label }) {
  const rows = Math.ceil(numbers.length / columns);
  const side = Math.min(MOST_SIDE, WIDE / columns);
  const greatest = Math.max(Math.abs(low), Math.abs(high)) || 1;
  const [paths, marks] = [new Map(), []];
  numbers.forEach((number, k) => {
    const [x, y] = [(k % columns) * side, Math.floor(k / columns) * side];
    const level = Number.isFinite(number) ? Math.ceil((LEVELS * Math.abs(number)) / greatest) : LEVELS;
    const key = `${kindOf(number)} ${level}`;
    if (level > 0) paths.set(key, (paths.get(key) ?? "") + box(x, y, side, side));
    if (changed.has(k)) marks.push(box(x + 1, y + 1, side - 2, side - 2));
  });
  const inks = [...paths].map(([key, d]) => {
    const [kind, level] = key.split(" ");
    return drawn("path", { d, class: `steps-cell-${kind}`, "fill-opacity": (0.1 + (0.9 * level) / LEVELS).toFixed(2) });
  });
  const lines = drawn("path", { d: grid(columns, rows, side), class: "steps-cell-lines" });
  const ring = marks.length > 0 ? [drawn("path", { d: marks.join(""), class: "steps-cell-changed" })] : [];
  const at = (x, y) => Math.floor(y / side) * columns + Math.floor(x / side);
  return framed(columns * side, rows * side, label, [...inks, lines, ...ring], (x, y) => {
    const k = at(x, y);
    return values[k] === undefined ? "" : `[${Math.floor(k / columns)}, ${k % columns}]\u00a0: ${exact(values[k])}`;
  });
}

function bars(numbers, values, _sizes, changed, { low, high, label }) {
  const [bottom, top] = [Math.min(low, 0), Math.max(high, 0)];
  const y = (number) => (TALL - 4) * (1 - (number - bottom) / (top - bottom || 1)) + 2;
  const wide = WIDE / numbers.length;
  const [paths, marks] = [new Map(), []];
  numbers.forEach((number, k) => {
    const [from, to] = Number.isFinite(number) ? [y(Math.max(number, 0)), y(Math.min(number, 0))] : [0, TALL];
    const bar = box(k * wide, from, Math.max(0.6, wide - Math.min(1, wide / 4)), Math.max(1, to - from));
    paths.set(kindOf(number), (paths.get(kindOf(number)) ?? "") + bar);
    if (changed.has(k)) marks.push(bar);
  });
  const inks = [...paths].map(([kind, d]) => drawn("path", { d, class: `steps-cell-${kind}` }));
  const ring = marks.length > 0 ? [drawn("path", { d: marks.join(""), class: "steps-cell-changed" })] : [];
  return framed(WIDE, TALL, label, [...inks, ...ring], (x) => {
    const k = Math.floor(x / wide);
    return values[k] === undefined ? "" : `[${k}]\u00a0: ${exact(values[k])}`;
  });
}

function kindOf(number) {
  return !Number.isFinite(number) ? "none" : number < 0 ? "minus" : "plus";
}

function box(x, y, width, height) {
  return `M${x.toFixed(1)} ${y.toFixed(1)}h${width.toFixed(1)}v${height.toFixed(1)}h${(-width).toFixed(1)}z`;
}

function grid(columns, rows, side) {
  const down = Array.from({ length: columns - 1 }, (_, k) => `M${((k + 1) * side).toFixed(1)} 0v${rows * side}`);
  const across = Array.from({ length: rows - 1 }, (_, k) => `M0 ${((k + 1) * side).toFixed(1)}h${columns * side}`);
  return [...down, ...across].join("");
}

/** `told(x, y)`: what the pointer is on. */
function framed(width, height, label, parts, told) {
  const words = drawn("title");
  const svg = drawn("svg", { viewBox: `0 0 ${width} ${height}`, style: `max-width: ${width}px`, class: "steps-picture", role: "img", "aria-label": label }, words, ...parts);
  svg.addEventListener("pointermove", ({ offsetX, offsetY }) => {
    const scale = width / (svg.clientWidth || width);
    words.textContent = told(offsetX * scale, offsetY * scale);
  });
  return svg;
}
