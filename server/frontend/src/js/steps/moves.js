// Where one goes from a step. Calls are folded: the steps that one goes through are those of the call that one is in, and
// of those that led to it; one enters another call on purpose.

import { last } from "./trace.js";

export class Moves {
  #open = new Map(); // of each frame, the steps that are gone through while one is in it

  constructor(trace) {
    this.trace = trace;
  }

  /** The steps that are gone through while one is at `step`. */
  open(step) {
    const frame = this.trace.steps[step].frame;
    if (!this.#open.has(frame)) {
      const way = new Set(this.trace.path(frame));
      const steps = this.trace.steps.flatMap((one, k) => (way.has(one.frame) ? [k] : []));
      this.#open.set(frame, steps);
    }
    return this.#open.get(frame);
  }

  /** The place of a step among those that are gone through. */
  place(step) {
    return last(this.open(step), step, (one) => one);
  }

  /** The step that is `by` further; the first or the last, beyond them. */
  by(step, by) {
    const open = this.open(step);
    return open[Math.min(Math.max(this.place(step) + by, 0), open.length - 1)];
  }

  first() {
    return 0;
  }

  last() {
    return this.trace.length - 1;
  }

  /** The first step of the call that the line of `step` makes; null where it makes none of the program's own. */
  into(step) {
    const next = this.trace.steps[step + 1];
    return !next || this.trace.path(this.trace.steps[step].frame).includes(next.frame) ? null : step + 1;
  }

  /** Where one is once the call is over; null where it is the outermost one. */
  out(step) {
    const { frame } = this.trace.steps[step];
    const callers = new Set(this.trace.path(frame).slice(0, -1));
    if (callers.size === 0) return null;
    const found = this.trace.steps.findIndex((one, k) => k > step && callers.has(one.frame));
    return found < 0 ? this.last() : found;
  }

  /** How many steps the call that begins at a step takes, with the calls that it makes. */
  size(begun) {
    const { steps } = this.trace;
    let end = begun;
    while (end < steps.length && this.trace.path(steps[end].frame).includes(steps[begun].frame)) end += 1;
    return end - begun;
  }

  /** The next step (`by` 1), or the one before (−1), at which a name of a frame changes; null where there is none. */
  change(step, frame, name, by) {
    const history = this.trace.history(frame, name);
    return history[last(history, by > 0 ? step : step - 1) + (by > 0 ? 1 : 0)]?.step ?? null;
  }

  /** The next time that a line is about to be executed, the first one again after the last: {step, time, times}, or null. */
  line(step, line) {
    const passages = this.trace.passages(line);
    if (passages.length === 0) return null;
    const at = (last(passages, step, (one) => one) + 1) % passages.length;
    return { step: passages[at], time: at + 1, times: passages.length };
  }
}
