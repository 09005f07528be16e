// A program step by step: its code, its variables at the step that is shown, and the moves from one step to another.

import { make } from "../replays/dom.js";
import { Code } from "./code.js";
import { Controls, help } from "./controls.js";
import { Loops } from "./loops.js";
import { Moves } from "./moves.js";
import { Scene } from "./scene.js";
import { Table } from "./table.js";
import { Trace } from "./trace.js";
import { Values } from "./values.js";
import { Variables } from "./variables.js";
import { callOf, sentence } from "./words.js";

const EDGE = 8; // pixels
const NARROW = window.matchMedia("(max-width: 52rem)");

export class Player {
  #step = 0;
  #frame = null; // whose variables are shown, when it is not that of the step

  /** `told`: elements of the verdict, what was expected first, that stand beside what comes back. */
  constructor(data, told = []) {
    this.trace = new Trace(data);
    this.told = told;
    this.moves = new Moves(this.trace);
    this.loops = new Loops(this.trace);
    this.values = new Values();
    const go = (step) => this.go(step);
    this.scene = new Scene(this.trace, () => this.#draw());
    this.code = new Code(this.trace, (line) => this.#toLine(line));
    this.variables = new Variables({ values: this.values, scene: this.scene, seek: (name, by) => this.#toChange(name, by), again: () => this.#draw() });
    this.table = new Table(this.trace, this.moves, go);
    this.crumbs = make("nav", { class: "steps-crumbs", "aria-label": "Appels en cours" });
    this.status = make("p", { class: "steps-status", role: "status" });
    this.end = make("div", { class: "steps-end", hidden: true });
    this.controls = new Controls({ go, moves: this.moves, now: () => this.#step, rounding: (exactly) => this.#round(exactly) });
    this.element = make("div", { class: "steps-player" }, this.#body(data), ...(this.trace.length > 0 ? [this.controls.element] : []));
    this.element.addEventListener("keydown", (event) => this.#key(event));
  }

  #body(data) {
    const empty = this.trace.length === 0;
    this.left = make("section", { class: "steps-code", "aria-label": "Code" }, ...(empty ? [] : [this.crumbs]), this.code.element);
    this.state = make("div", { class: "steps-state", tabindex: "0", role: "group", "aria-label": "Variables" });
    const rest = empty ? [this.#over(data)] : [this.end, this.variables.element, this.controls.exactness];
    this.state.append(...rest, ...this.#notes(data), ...(empty ? [] : [this.table.element, help()]));
    NARROW.addEventListener("change", () => this.#placeScene());
    this.#placeScene();
    return make("div", { class: "steps-body" }, this.left, make("section", { class: "steps-side", "aria-label": "État" }, ...(empty ? [] : [this.status]), this.state));
  }

  /** Under the code, or, in one column, after the variables. */
  #placeScene() {
    if (NARROW.matches) this.variables.element.after(this.scene.element);
    else this.left.append(this.scene.element);
  }

  #notes({ left_out: leftOut, stdout }) {
    const notes = leftOut.length > 0 ? [make("ul", { class: "steps-left-out" }, ...leftOut.map((words) => make("li", {}, words)))] : [];
    if (stdout) notes.push(make("details", { class: "steps-table" }, make("summary", { "data-focus": "stdout" }, "Ce que le code a affiché"), make("pre", { class: "printed", tabindex: "0" }, stdout)));
    return notes;
  }

  /** Once it stands on the page. */
  begin() {
    if (this.trace.length === 0) return this.code.show(this.trace.data.end.line, null);
    this.go(0);
  }

  go(step, words = null) {
    if (step === null || this.trace.length === 0) return;
    this.#step = step;
    this.#frame = null;
    this.#draw(words);
  }

  #draw(words = null) {
    const step = this.#step;
    const focus = document.activeElement?.dataset?.focus;
    const { event, frame, line } = this.trace.steps[step];
    const shown = this.#frame ?? frame;
    const variables = this.trace.variables(step, shown);
    const over = event === "return" || event === "exception";
    this.variables.show(variables);
    this.scene.show(variables, shown);
    this.controls.show(step, this.loops.around(step));
    this.table.show(step);
    this.#showPath(step, shown);
    this.end.hidden = step !== this.trace.length - 1;
    this.end.replaceChildren(...(this.end.hidden ? [] : [this.#over(this.trace.data)]));
    this.status.setAttribute("aria-live", document.activeElement === this.controls.range ? "off" : "polite");
    this.#say(`${words ? `${words} ` : ""}${sentence(this.trace, step)}`);
    this.code.show(over ? null : line, this.trace.executed(step)); // once all that takes room beside it stands
    this.#keepFocus(focus);
    this.#revealChange();
  }

  /** What has just changed is in sight, or the end is. */
  #revealChange() {
    const { state } = this;
    const rows = this.end.hidden ? [...this.variables.element.querySelectorAll(".steps-variable-changed")] : [this.end];
    if (rows.length === 0) return;
    const around = state.getBoundingClientRect();
    const [top, bottom] = [rows[0].getBoundingClientRect().top, rows.at(-1).getBoundingClientRect().bottom];
    if (top < around.top) state.scrollTop -= around.top - top + EDGE;
    else if (bottom > around.bottom) state.scrollTop += Math.min(bottom - around.bottom + EDGE, top - around.top - EDGE);
  }

  /** Once: what says the same again would be read again. */
  #say(words) {
    if (this.status.textContent !== words) this.status.textContent = words;
  }

  /** What is made anew at each move would lose the focus. */
  #keepFocus(name) {
    if (!name || document.activeElement?.dataset?.focus === name) return;
    const again = this.element.querySelector(`[data-focus="${CSS.escape(name)}"]`);
    (again ?? this.controls.buttons.on).focus({ preventScroll: true });
  }

  #showPath(step, shown) {
    const way = this.trace.path(this.trace.steps[step].frame);
    const choose = (frame) => () => {
      this.#frame = frame;
      this.#draw();
    };
    const parts = way.flatMap((frame, k) => {
      const look = { type: "button", class: "link-button", "aria-pressed": String(frame === shown), "data-focus": `call:${frame}`, onclick: choose(frame) };
      const name = callOf(this.trace, frame);
      const one = way.length > 1 ? make("button", look, name) : make("span", {}, name);
      return k > 0 ? [make("span", { "aria-hidden": "true" }, " › "), one] : [one];
    });
    this.crumbs.replaceChildren(...parts);
  }

  /** How it ended; where steps are missing before that, it is said first. */
  #over(data) {
    const last = data.steps.at(-1);
    const whole = !last || ((last.event === "return" || last.event === "exception") && data.frames[last.frame].parent === null);
    const missing = whole ? [] : [make("p", { class: "steps-missing" }, "La suite n’est pas montrée. ", ...data.left_out.map((words) => `${words} `))];
    return make("div", {}, ...missing, this.#ended(data.end));
  }

  #ended(end) {
    if (end.kind === "returned") {
      if (!end.value) return make("p", {}, "Le programme est allé au bout.");
      const got = make("div", { class: this.told.length > 0 ? "got" : "" }, make("h3", {}, "Renvoyé"), make("div", { class: "value" }, this.#returned(end.value)));
      return make("div", { class: "counterexample" }, ...this.told.map((one) => one.cloneNode(true)), got);
    }
    const look = end.kind === "fault" ? "steps-over steps-over-fault" : "steps-over";
    const where = end.line ? ` (ligne ${end.line})` : "";
    return make("div", { class: look }, make("strong", {}, `${end.title}${end.title ? where : ""}`), make("p", {}, end.message), ...(this.told.length > 0 ? [make("div", { class: "counterexample" }, ...this.told.map((one) => one.cloneNode(true)))] : []));
  }

  /** What comes back, its parts under the names that the verdict gives them. */
  #returned(value) {
    const names = this.told.flatMap((one) => [...one.querySelectorAll(".named-value > code")].map((name) => name.textContent));
    if (names.length < 2 || value.kind !== "sequence" || value.items.length !== names.length) return this.values.show(value, { key: "fin" });
    const parts = names.map((name, k) => {
      const shown = this.values.show(value.items[k], { key: `fin${k}` });
      return make("div", { class: "named-value" }, make("code", {}, name), make("span", { "aria-hidden": "true" }, "="), shown);
    });
    return make("div", { class: "named-values" }, ...parts);
  }

  #round(exactly) {
    this.values.exactly = exactly;
    this.#draw();
  }

  #toChange(name, by) {
    const frame = this.#frame ?? this.trace.steps[this.#step].frame;
    const found = this.moves.change(this.#step, frame, name, by);
    if (found !== null) return this.go(found);
    this.#say(by > 0 ? `${name} ne change plus.` : `${name} ne change pas avant.`);
  }

  #toLine(line) {
    const found = this.moves.line(this.#step, line);
    if (found) this.go(found.step, found.times > 1 ? `Passage ${found.time} sur ${found.times}.` : "");
  }

  #key(event) {
    if (event.altKey || event.ctrlKey || event.metaKey || this.trace.length === 0) return;
    const { target } = event;
    const slides = target.type === "range";
    if (target.matches("select, textarea, input:not([type=range], [type=checkbox])")) return;
    const now = this.#step;
    const keys = {
      s: () => this.moves.by(now, 1),
      p: () => this.moves.by(now, -1),
      r: () => this.moves.first(),
      f: () => this.moves.last(),
      e: () => this.moves.into(now),
      o: () => this.moves.out(now),
      t: () => this.#nextLap(now),
      ...(slides || target.closest(".steps-grid, .steps-lines, .printed, .steps-table-scroll") ? {} : { arrowright: () => this.moves.by(now, 1), arrowleft: () => this.moves.by(now, -1) }),
    };
    const key = event.key.toLowerCase();
    if (key === "x") this.controls.exactly.click();
    else if (keys[key]) this.go(keys[key]());
    else return;
    event.preventDefault();
  }

  #nextLap(now) {
    const [inner] = this.loops.around(now);
    return inner ? (inner.laps[inner.lap + 1] ?? null) : null;
  }
}
