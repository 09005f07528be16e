// The points and poses of a step on one drawing, as they are and, dashed, as they were before the line that changed them.

import { decimal, make } from "../replays/dom.js";
import { french } from "./numbers.js";
import { drawable, rowsOf } from "./shapes.js";
import { drawn } from "./svg.js";

const [WIDE, TALL, MARGIN] = [360, 270, 26];
const LOOKS = 5; // of the shapes and colours, in turn
const LEAST_SPAN = 1;
const CROWD = 60; // points, from which they are small
/** Where the name of each stands beside its first mark: points at one place do not hide each other's names. */
const BESIDE = [
  { x: 9, y: -7 }, { x: 9, y: 17 }, { x: -9, y: -7, "text-anchor": "end" }, { x: -9, y: 17, "text-anchor": "end" },
  { x: 0, y: -14, "text-anchor": "middle" },
]; // prettier-ignore

export class Scene {
  #choices = new Map(); // what a name is drawn as: first a guess, then what the reader wants

  constructor(trace, changed) {
    this.trace = trace;
    this.changed = changed;
    this.element = make("figure", { class: "steps-scene", hidden: true });
  }

  /** How a variable is drawn: « points », « poses » or "". */
  choice(name, value) {
    if (!this.#choices.has(name)) {
      const may = drawable(name, value);
      if (!may) return "";
      this.#choices.set(name, may.guess); // what it is first taken for, it stays
    }
    return this.#choices.get(name);
  }

  /** What lets the reader choose, for a variable that may be drawn; null for others. */
  chooser(name, value) {
    const may = drawable(name, value);
    if (!may) return null;
    const words = { points: rowsOf(value).length > 1 ? "en points" : "en point", poses: rowsOf(value).length > 1 ? "en poses" : "en pose" };
    const options = [["", "non"], ...may.offered.map((one) => [one, words[one]])];
    const select = make("select", {
      "aria-label": `Dessiner ${name}`, "data-focus": `draw:${name}`,
      onchange: () => {
        this.#choices.set(name, select.value);
        this.changed();
      },
    }, ...options.map(([one, told]) => make("option", { value: one, selected: one === this.choice(name, value) }, told))); // prettier-ignore
    return make("label", { class: "steps-draw" }, "Dessiner\u00a0: ", select);
  }

  /** Draws the variables of a frame (`Trace.variables`). */
  show(variables, frame) {
    const shown = variables.filter(({ name, value }) => this.choice(name, value) !== "" && rowsOf(value));
    this.element.hidden = shown.length === 0;
    if (shown.length === 0) return this.element.replaceChildren();
    const paper = this.#paper(shown, frame);
    const parts = shown.map((one, k) => this.#marks(one, paper, k % LOOKS));
    const label = `Dessin de ${shown.map((one) => one.name).join(", ")}`;
    const svg = drawn("svg", { viewBox: `0 0 ${WIDE} ${TALL}`, role: "img", "aria-label": label }, ...axes(paper), ...parts.flat());
    const keys = shown.map((one, k) => make("li", { class: `steps-look-${k % LOOKS}` }, sample(this.choice(one.name, one.value), k % LOOKS), one.name, part(one.value)));
    const dashed = shown.some((one) => one.changed && one.before) ? [make("li", { class: "soft" }, "en tirets\u00a0: avant la dernière ligne")] : [];
    this.element.replaceChildren(svg, make("ul", { class: "steps-keys", role: "list" }, ...keys, ...dashed));
  }

  /** The same all along a call, so that what moves is seen to move. */
  #paper(shown, frame) {
    const all = shown.flatMap(({ name }) =>
      this.trace.history(frame, name).flatMap(({ value }) => (value === null ? [] : (rowsOf(value) ?? []))),
    );
    const [xs, ys] = [all.map((one) => one[0]), all.map((one) => one[1])];
    const [low, high] = [[least(xs), least(ys)], [most(xs), most(ys)]];
    const span = [0, 1].map((k) => Math.max(high[k] - low[k], LEAST_SPAN));
    const scale = Math.min((WIDE - 2 * MARGIN) / span[0], (TALL - 2 * MARGIN) / span[1]);
    const middle = [0, 1].map((k) => (low[k] + high[k]) / 2);
    return {
      x: (x) => WIDE / 2 + scale * (x - middle[0]),
      y: (y) => TALL / 2 - scale * (y - middle[1]),
      from: [middle[0] - WIDE / 2 / scale, middle[1] - TALL / 2 / scale],
      to: [middle[0] + WIDE / 2 / scale, middle[1] + TALL / 2 / scale],
    };
  }

  #marks({ name, value, changed, before }, paper, look) {
    const [rows, kind] = [rowsOf(value), this.choice(name, value)];
    const old = changed && before ? rowsOf(before) : null;
    const place = (row) => `translate(${paper.x(row[0]).toFixed(2)} ${paper.y(row[1]).toFixed(2)})`;
    const size = rows.length > CROWD ? " scale(0.5)" : "";
    const one = (row, was) => drawn("g", { transform: place(row) + size, class: `steps-look-${look}${was ? " steps-was" : ""}` }, sign(kind, look, row[2]));
    const words = drawn("text", BESIDE[look], name.slice(0, 24));
    const first = drawn("g", { transform: place(rows[0]), class: `steps-look-${look}` }, words);
    return [...(old ?? []).filter((row, k) => String(row) !== String(rows[k])).map((row) => one(row, true)), ...rows.map((row) => one(row, false)), first];
  }
}

/** A mark that stands for a point, of one of five shapes, or for a pose that looks at an angle. */
function sign(kind, look, angle = 0) {
  if (kind === "poses") return drawn("path", { d: "M-8 -6 L10 0 L-8 6 L-4 0 Z", transform: `rotate(${((-angle * 180) / Math.PI).toFixed(2)})` });
  const shapes = ["M-4 0a4 4 0 1 0 8 0a4 4 0 1 0 -8 0", "M-4 -4h8v8h-8z", "M0 -5l5 9h-10z", "M0 -5.5l5.5 5.5l-5.5 5.5l-5.5 -5.5z", "M-4 -4l8 8M4 -4l-8 8"];
  return drawn("path", { d: shapes[look] });
}

/** Of an array that is cut, how much of it is drawn. */
function part(value) {
  return value.cut ? `\u00a0(les ${rowsOf(value).length} premiers sur ${french(String(value.shape[0]))})` : "";
}

function sample(kind, look) {
  return drawn("svg", { viewBox: "-11 -8 22 16", width: 22, height: 16, "aria-hidden": "true" }, sign(kind, look));
}

function axes({ x, y, from, to }) {
  const step = round((to[0] - from[0]) / 5);
  const lines = [];
  for (const [k, place, size] of [[0, x, WIDE], [1, y, TALL]]) {
    for (let tick = Math.ceil(from[k] / step); tick * step <= to[k]; tick += 1) {
      const at = place(tick * step).toFixed(2);
      const ends = k === 0 ? { x1: at, x2: at, y1: 0, y2: TALL } : { x1: 0, x2: WIDE, y1: at, y2: at };
      lines.push(drawn("line", { ...ends, class: "steps-axis" }));
      const decimals = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
      const words = k === 0 ? { x: at, y: TALL - 4, "text-anchor": "middle" } : { x: 3, y: Number(at) - 3 };
      const inside = Number(at) > MARGIN && Number(at) < size - MARGIN;
      if (inside) lines.push(drawn("text", { ...words, class: "steps-tick" }, decimal(tick * step, Math.min(decimals, 6))));
    }
  }
  return lines;
}

/** The round number that is the nearest above. */
function round(rough) {
  const power = 10 ** Math.floor(Math.log10(rough));
  return [1, 2, 5, 10].find((one) => one * power >= rough * 0.999) * power;
}

function least(numbers) {
  return numbers.reduce((a, b) => Math.min(a, b), Infinity);
}

function most(numbers) {
  return numbers.reduce((a, b) => Math.max(a, b), -Infinity);
}
