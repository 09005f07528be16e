// The program, with an arrow at the line to come and another at the line that has just been executed.

import { make } from "../replays/dom.js";
import { counted } from "./words.js";

const MARGIN = 48; // pixels: two lines

const LOOKS = { keyword: "steps-keyword", string: "steps-string", number: "steps-literal", comment: "steps-comment", def: "steps-def", meta: "steps-def" };

export class Code {
  #marked = [];

  /** `goTo(line)` is called when the number of a line is clicked. */
  constructor(trace, goTo) {
    const { lines, mark, end } = trace.data;
    this.rows = lines.map((text, index) => this.#row(text, index + 1, trace.passages(index + 1).length, goTo));
    this.element = make("ol", { class: "steps-lines code", tabindex: "0", "aria-label": "Le code, ligne à ligne" }, ...this.rows);
    this.element.addEventListener("keydown", (event) => this.#walk(event));
    if (mark) this.#note(mark.line, "steps-mistake", "Erreur reconnue", mark.words);
    if (end.kind === "fault" && end.line) this.row(end.line)?.classList.add("steps-fault");
    this.#colour(lines);
  }

  row(line) {
    return this.rows[line - 1];
  }

  #row(text, line, times, goTo) {
    const told = times > 0 ? `Ligne ${line}, ${counted(times, "passage")} : aller au suivant` : `Ligne ${line}, sans passage ici`;
    const number = times > 0
      ? make("button", { type: "button", class: "steps-number", tabindex: "-1", title: told, "aria-label": told, onclick: () => goTo(line) }, String(line))
      : make("span", { class: "steps-number", title: told }, String(line)); // prettier-ignore
    const arrow = make("span", { class: "steps-arrow" });
    return make("li", { class: times > 0 ? "" : "steps-never" }, arrow, number, make("code", {}, text || " "));
  }

  #note(line, look, title, words) {
    const row = this.row(line);
    row?.classList.add(look);
    row?.append(make("p", { class: "steps-mark-note" }, make("strong", {}, `${title}. `), words));
  }

  /** Without its colours the code can be read as well: they are loaded apart, where they can be had. */
  async #colour(lines) {
    const colouring = await import("./colouring.js").catch(() => null);
    colouring?.coloured(lines).forEach((pieces, index) => {
      if (pieces.length === 0 || !this.rows[index]) return;
      const parts = pieces.map(([piece, look]) => (LOOKS[look] ? make("span", { class: LOOKS[look] }, piece) : piece));
      this.rows[index].querySelector("code").replaceChildren(...parts);
    });
  }

  /** The arrows go from one line's number to another's: Enter then leads to its next passage. */
  #walk(event) {
    const by = { ArrowDown: 1, ArrowUp: -1 }[event.key];
    if (!by) return;
    const numbers = [...this.element.querySelectorAll("button.steps-number")];
    const now = numbers.indexOf(document.activeElement);
    const current = numbers.findIndex((one) => this.#marked.includes(one.parentElement));
    numbers[Math.min(Math.max(now < 0 ? current : now + by, 0), numbers.length - 1)]?.focus();
    event.preventDefault();
  }

  /** `next`: the line to be executed, `done`: the one that has just been; null for none. */
  show(next, done) {
    for (const row of this.#marked) {
      row.classList.remove("steps-next", "steps-done");
      row.querySelector(".steps-arrow").replaceChildren();
      row.removeAttribute("aria-current");
    }
    this.#marked = [];
    const put = (line, look, sign, words) => {
      const row = line === null ? null : this.row(line);
      if (!row) return;
      row.classList.add(look);
      row.querySelector(".steps-arrow").append(make("span", { "aria-hidden": "true" }, sign), make("span", { class: "visually-hidden" }, words));
      this.#marked.push(row);
    };
    put(done, "steps-done", "▹", "vient d’être exécutée : ");
    put(next, "steps-next", "▶", "à exécuter : ");
    if (next !== null) this.row(next)?.setAttribute("aria-current", "step");
    this.#reveal(this.row(next ?? done ?? 0));
  }

  /** Scrolls the code alone, and only where the line is out of sight or at its edge. */
  #reveal(row) {
    if (!row) return;
    const list = this.element;
    const [top, height, seen] = [row.offsetTop, row.offsetHeight, list.clientHeight];
    const margin = Math.min(MARGIN, seen / 4);
    if (top < list.scrollTop + margin) list.scrollTop = top - margin;
    else if (top + height > list.scrollTop + seen - margin) list.scrollTop = top + height - seen + margin;
  }
}
