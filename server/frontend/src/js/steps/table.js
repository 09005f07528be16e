// The steps as a table: the whole course of the program for who reads it rather than watches it.

import { make } from "../replays/dom.js";
import { brief, counted, nameOf } from "./words.js";

const MOST_ROWS = 300; // at once: a table of thousands is heavy
const MOST_CHANGES = 6;

export class Table {
  #open = null;
  #current = null;

  /** `go(step)` when a step is chosen. */
  constructor(trace, moves, go) {
    Object.assign(this, { trace, moves, go });
    this.body = make("tbody");
    const head = make("tr", {}, ...["Étape", "Ligne", "Code", "Ce qui change"].map((words) => make("th", { scope: "col" }, words)));
    const caption = make("caption", { class: "visually-hidden" }, "Les étapes, dans l’ordre");
    const table = make("table", {}, caption, make("thead", {}, head), this.body);
    this.left = make("p", { class: "soft small" });
    const scroll = make("div", { class: "steps-table-scroll", tabindex: "0", role: "group", "aria-label": "Tableau des étapes" }, table);
    this.element = make("details", { class: "steps-table" }, make("summary", { "data-focus": "table" }, "Toutes les étapes, en tableau"), scroll, this.left);
    this.element.addEventListener("toggle", () => this.show(this.step));
  }

  show(step) {
    this.step = step;
    if (!this.element.open) return;
    const open = this.moves.open(step);
    const [from, to] = window(this.moves.place(step), open.length);
    if (this.#open?.steps !== open || this.#open.from !== from) {
      this.#open = { steps: open, from };
      this.rows = new Map(open.slice(from, to).map((one, k) => [one, this.#row(one, from + k + 1)]));
      this.body.replaceChildren(...this.rows.values());
      this.left.textContent = to - from < open.length ? `Étapes ${from + 1} à ${to}, sur ${open.length}.` : "";
    }
    this.#current?.removeAttribute("aria-current");
    this.#current = this.rows.get(step);
    this.#current?.setAttribute("aria-current", "step");
  }

  #row(step, number) {
    const { line, event, frame } = this.trace.steps[step];
    const go = make("button", { type: "button", class: "link-button", "data-focus": `row:${step}`, onclick: () => this.go(step) }, String(number));
    const code = event === "call" ? `appel de ${nameOf(this.trace.frames[frame].function)}` : this.trace.lines[line - 1]?.trim();
    return make("tr", {}, make("td", {}, go), make("td", {}, line > 0 ? String(line) : ""), make("td", {}, make("code", {}, code ?? "")), make("td", {}, this.#changes(step)));
  }

  #changes(step) {
    const { event, value, words, frame } = this.trace.steps[step];
    if (event === "exception") return words;
    if (event === "return") return value ? `${nameOf(this.trace.frames[frame].function)} renvoie ${brief(value)}` : "";
    const { changes, gone } = this.trace.effects(step);
    const told = changes.slice(0, MOST_CHANGES).map(({ name, value: held }) => `${name} = ${brief(held)}`);
    if (changes.length > MOST_CHANGES) told.push(counted(changes.length - MOST_CHANGES, "autre"));
    const into = this.moves.into(step);
    if (into !== null) told.push(`appel de ${nameOf(this.trace.frames[this.trace.steps[into].frame].function)}`);
    return [...told, ...gone.map((name) => `${name} n’existe plus`)].join(" ; ");
  }
}

/** The rows around a place: pieces that begin at fixed places, so that the table does not change at each move. */
function window(place, length) {
  if (length <= MOST_ROWS) return [0, length];
  const from = Math.min(Math.floor(place / (MOST_ROWS / 2)) * (MOST_ROWS / 2), length - MOST_ROWS);
  return [from, from + MOST_ROWS];
}
