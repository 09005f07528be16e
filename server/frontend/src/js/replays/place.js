// A point that the reader places on the drawing before a replay plays: by a click, by a finger, or by its two numbers.

import { decimal, lowered, make } from "./dom.js";

const TEXT = /^-?\d{1,4}(\.\d{1,2})?,-?\d{1,4}(\.\d{1,2})?$/;
const STILL = 6; // pixels that a click may move: beyond, something was dragged

export class Place {
  #fields = [];
  #pressed = null;

  /** `changed()` is called when the point moves; `prepare()` when the reader first comes to it. */
  constructor(place, stage, { changed, prepare }) {
    Object.assign(this, { ...place, stage, changed, prepare });
    this.at = null;
    this.open = false;
    const { canvas } = stage;
    canvas.addEventListener("pointerdown", (event) => (this.#pressed = [event.clientX, event.clientY]));
    canvas.addEventListener("click", (event) => this.#click(event));
  }

  /** The place of a text that was kept; nothing where it is none. */
  read(text) {
    if (!TEXT.test(text ?? "")) return undefined;
    const [x, y] = text.split(",").map(Number);
    const [x0, y0, x1, y1] = this.box;
    return x >= x0 && x <= x1 && y >= y0 && y <= y1 ? [x, y] : undefined;
  }

  /** How far it is from where it happens: from the nearest of the places where it does. */
  away([x, y]) {
    return Math.min(...this.spots.map(([sx, sy]) => Math.hypot(x - sx, y - sy)));
  }

  /** That distance, and what to think of it, in words. */
  verdict(at) {
    const away = this.away(at);
    const unit = this.unit === "case" && away >= 2 ? "cases" : this.unit;
    const words = `à ${decimal(away, 1)}\u00a0${unit} de là`;
    if (away <= this.near) return { good: true, words: ` ✓ ${words}, c’est bien vu` };
    return { good: false, words: away <= this.far ? ` ≈ ${words}, pas loin` : ` ✗ ${words}` };
  }

  words([x, y]) {
    return `x = ${decimal(x, 2)}, y = ${decimal(y, 2)}`;
  }

  /** The two numbers, which follow the drawing and lead it. */
  fields() {
    const [x0, y0, x1, y1] = this.box;
    const bounds = [[x0, x1], [y0, y1]]; // prettier-ignore
    const names = ["x, vers la droite", this.up ? "y, vers le haut" : "y, vers le bas"];
    this.#fields = names.map((name, i) => {
      const [min, max] = bounds[i];
      const input = make("input", { type: "number", required: true, min, max, step: "any", oninput: () => this.#typed() });
      input.addEventListener("keydown", (event) => this.#press(event, i));
      return { label: make("label", {}, make("span", {}, name), input), input };
    });
    this.open = true;
    const help = "Touchez le dessin là où vous l’attendez, ou écrivez ses deux nombres.";
    return make(
      "div", { class: "replay-place", onfocusin: () => this.prepare() },
      make("p", { class: "help" }, help), ...this.#fields.map((one) => one.label),
    ); // prettier-ignore
  }

  /** What is kept of it. */
  get text() {
    return this.at.map((one) => String(Number(one.toFixed(2)))).join(",");
  }

  /** Where the reader has put it, and where it is in the end once that may be told. */
  layers(seen) {
    if (!this.at) return [];
    const mine = { kind: "pose", style: "target", color: "accent", radius: 0.01, at: [...this.at, 0], label: "vous" };
    if (!seen) return [mine];
    const nearest = this.spots.reduce((best, spot) => (gap(spot, this.at) < gap(best, this.at) ? spot : best));
    const rows = (values, columns) => ({ columns, count: values.length / columns, values: Float64Array.from(values) });
    return [
      { kind: "segments", color: "ink", width: 1.5, opacity: 0.8, dashed: true, moved: rows([...this.at, ...nearest], 4) },
      ...this.spots.map(([x, y]) => ({ kind: "pose", style: "target", color: "ink", radius: 0.01, at: [x, y, 0], label: "" })),
      mine,
    ];
  }

  #click(event) {
    if (!this.open || !this.#pressed) return;
    const [x, y] = this.#pressed;
    if (Math.hypot(event.clientX - x, event.clientY - y) > STILL) return;
    this.prepare();
    const page = this.stage.canvas.getBoundingClientRect();
    this.#put(...this.stage.paper.back(event.clientX - page.left, event.clientY - page.top));
  }

  #put(x, y) {
    const [x0, y0, x1, y1] = this.box;
    const stepped = (value, low, high) => Number(Math.min(Math.max(Math.round(value / this.step) * this.step, low), high).toFixed(2));
    this.at = [stepped(x, x0, x1), stepped(y, y0, y1)];
    this.#fields.forEach(({ input }, i) => (input.value = String(this.at[i])));
    this.changed();
  }

  /** An arrow moves the point by a step, from the middle where there is none yet. */
  #press(event, i) {
    const way = { ArrowUp: 1, ArrowDown: -1 }[event.key];
    if (!way || event.altKey || event.ctrlKey || event.metaKey) return;
    event.preventDefault();
    const [x0, y0, x1, y1] = this.box;
    const from = this.at ?? [(x0 + x1) / 2, (y0 + y1) / 2];
    const to = from.map((value, k) => (k === i && this.at ? value + way * this.step * (event.shiftKey ? 4 : 1) : value));
    this.#put(...to);
  }

  #typed() {
    const [x, y] = this.#fields.map(({ input }) => (input.value === "" ? NaN : Number(input.value)));
    this.at = this.read(`${x.toFixed(2)},${y.toFixed(2)}`) ?? null;
    this.changed();
  }
}

function gap([x, y], [u, v]) {
  return Math.hypot(x - u, y - v);
}
