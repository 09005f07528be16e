// What a trace tells, rebuilt: the variables of any call at any step, and what each line has changed.

export class Trace {
  #histories; // of each frame: name → [{step, value (null once deleted), entries}], in the order of the steps
  #own; // of each frame: its steps, in order
  #paths = new Map();
  #passages = null;

  /** `data` is what the server answers (`TraceOut` in server/steps/schemas.py). */
  constructor(data) {
    this.data = data;
    this.steps = data.steps;
    this.frames = data.frames;
    this.lines = data.lines;
    this.#histories = data.frames.map(() => new Map());
    this.#own = data.frames.map(() => []);
    data.steps.forEach(({ frame, changes, gone }, step) => {
      this.#own[frame].push(step);
      const history = this.#histories[frame];
      const note = (name, value, entries) => {
        if (!history.has(name)) history.set(name, []);
        history.get(name).push({ step, value, entries });
      };
      for (const { name, value, entries } of changes) note(name, value, entries);
      for (const name of gone) note(name, null, []);
    });
  }

  get length() {
    return this.steps.length;
  }

  /** The variables of a frame at a step, those that came first first. `before`: the value until then, if it has just changed. */
  variables(step, frame = this.steps[step].frame) {
    const found = [];
    for (const [name, history] of this.#histories[frame]) {
      const at = last(history, step);
      if (at < 0 || history[at].value === null) continue;
      const { step: since, value, entries } = history[at];
      const before = at > 0 ? history[at - 1].value : null;
      const changed = since === step;
      found.push({ name, value, changed, fresh: changed && before === null, entries: changed ? entries : [], before });
    }
    return found;
  }

  /** What one name holds along its frame: [{step, value}], `value` null from where it is deleted. */
  history(frame, name) {
    return this.#histories[frame]?.get(name) ?? [];
  }

  /** The steps of one call, without those of the calls that it makes. */
  own(frame) {
    return this.#own[frame] ?? [];
  }

  /** The step of the same call that comes before or after a step; null where there is none. */
  beside(step, by) {
    const own = this.own(this.steps[step].frame);
    return own[last(own, step, (one) => one) + by] ?? null;
  }

  /** The line that has just been executed in the call of a step: null where it has just begun. */
  executed(step) {
    const { event, line } = this.steps[step];
    if (event === "return" || event === "exception") return line;
    const before = this.beside(step, -1);
    return before === null || this.steps[before].event === "call" ? null : this.steps[before].line;
  }

  /** What the line of a step changes, as its call's next step tells: names, and those deleted. */
  effects(step) {
    const { event, changes, gone } = this.steps[step];
    if (event === "call") return { changes, gone };
    const next = event === "line" ? this.beside(step, 1) : null;
    return next === null ? { changes: [], gone: [] } : this.steps[next];
  }

  /** A frame and those that led to it, from the outside in. */
  path(frame) {
    if (!this.#paths.has(frame)) {
      const { parent } = this.frames[frame]; // it was there before
      this.#paths.set(frame, parent === null ? [frame] : [...this.path(parent), frame]);
    }
    return this.#paths.get(frame);
  }

  /** The steps at which a line was about to be executed. */
  passages(line) {
    if (!this.#passages) {
      this.#passages = new Map();
      this.steps.forEach((one, step) => {
        if (one.event !== "line") return;
        if (!this.#passages.has(one.line)) this.#passages.set(one.line, []);
        this.#passages.get(one.line).push(step);
      });
    }
    return this.#passages.get(line) ?? [];
  }
}

/** The place of the last item that is not past a step, −1 where there is none. */
export function last(items, step, stepOf = (item) => item.step) {
  let [low, high] = [0, items.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (stepOf(items[middle]) <= step) low = middle + 1;
    else high = middle;
  }
  return low - 1;
}
