// Something to take hold of on a drawing: by mouse, by finger, or with the arrow keys once it has the focus.

import { decimal, make } from "../replays/dom.js";

const KEYS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
const LARGE = 5; // steps that a key goes with Shift

export class Handle {
  /**
   * `at`: [x, y] in the units of the scene; `box`: [x0, y0, x1, y1], where it may go; `step`: what a key moves it by.
   * `told(x, y)`: where it is, in words. `moved(x, y, how)`: it was moved, `how` being "hand" or "key"; `held(yes)`:
   * it was taken or let go; `key(event)`: another key, true when that did something. `shown`: false where the drawing
   * shows it already, and only the focus is to be seen.
   */
  constructor(bench, { label, at, box, step, told, moved, held, key, look = "" }) {
    Object.assign(this, { bench, at: [...at], box, step, moved, held, key });
    this.told = told ?? ((x, y) => `x = ${decimal(x, 2)}, y = ${decimal(y, 2)}`);
    this.holding = false;
    this.element = make("div", {
      class: `hand ${look}`, role: "slider", tabindex: "0", "aria-label": label,
      "aria-valuemin": String(box[0]), "aria-valuemax": String(box[2]),
    }); // prettier-ignore
    this.element.addEventListener("pointerdown", (event) => this.#take(event));
    this.element.addEventListener("pointermove", (event) => this.#follow(event));
    for (const end of ["pointerup", "pointercancel"]) this.element.addEventListener(end, () => this.#letGo());
    this.element.addEventListener("keydown", (event) => this.#press(event));
    bench.hands.append(this.element);
    this.put(...at);
  }

  /** Put it somewhere, without a word to `moved`. */
  put(x, y) {
    this.at = [x, y];
    this.element.setAttribute("aria-valuenow", String(Number(x.toFixed(3))));
    this.element.setAttribute("aria-valuetext", this.told(x, y));
    this.place();
  }

  /** Where it is on the page, which may have changed its size. */
  place() {
    const { paper } = this.bench.stage;
    if (!paper) return;
    this.element.style.translate = `${paper.x(this.at[0])}px ${paper.y(this.at[1])}px`;
  }

  #to(x, y, how) {
    const [x0, y0, x1, y1] = this.box;
    this.put(Math.min(Math.max(x, x0), x1), Math.min(Math.max(y, y0), y1));
    this.moved(...this.at, how);
  }

  #take(event) {
    if (!event.isPrimary || event.button > 0) return;
    this.element.setPointerCapture(event.pointerId);
    this.element.focus({ preventScroll: true });
    const { paper } = this.bench.stage;
    this.offset = [event.clientX - paper.x(this.at[0]), event.clientY - paper.y(this.at[1])];
    this.holding = true;
    this.held?.(true);
    event.preventDefault();
  }

  #follow(event) {
    if (!this.holding) return;
    const place = [event.clientX - this.offset[0], event.clientY - this.offset[1]];
    this.#to(...this.bench.stage.paper.back(...place), "hand");
  }

  #letGo() {
    if (!this.holding) return;
    this.holding = false;
    this.held?.(false);
  }

  #press(event) {
    if (event.altKey || event.ctrlKey || event.metaKey) return;
    const way = KEYS[event.key];
    if (way) {
      const stride = this.step * (event.shiftKey ? LARGE : 1);
      this.#to(this.at[0] + stride * way[0], this.at[1] + stride * way[1] * this.bench.stage.paper.turn, "key");
    } else if (!this.key?.(event)) return;
    event.preventDefault();
  }
}
