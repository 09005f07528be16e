// The loops of a program, read from how its lines are indented, and their laps, counted in a trace.

const HEADER = /^(\s*)(?:async\s+)?(for|while)\b/;
const ENDLESS = /^\s*while\s*\(?\s*(True|1)\b\s*\)?\s*:/;
const NO_LINE = /^\s*(#.*)?$/;

/** [{header, ends (the last line of the header), first, last (of the body), endless}], lines from 1. One-line loops have no laps to show. */
export function loopsOf(lines) {
  const found = [];
  lines.forEach((text, index) => {
    const indent = HEADER.exec(text)?.[1].length;
    if (indent === undefined) return;
    const ends = endOfHeader(lines, index);
    if (ends === null) return;
    let last = ends;
    for (let k = ends + 1; k < lines.length; k += 1) {
      if (NO_LINE.test(lines[k])) continue;
      if (indentOf(lines[k]) <= indent) break;
      last = k;
    }
    if (last > ends) found.push({ header: index + 1, ends: ends + 1, first: ends + 2, last: last + 1, endless: ENDLESS.test(text) });
  });
  return found;
}

function indentOf(text) {
  return text.length - text.trimStart().length;
}

/** The index of the line on which what begins at `index` comes to its colon; null where something follows it there. */
function endOfHeader(lines, index) {
  let depth = 0;
  for (let k = index; k < Math.min(lines.length, index + 20); k += 1) {
    const text = bare(lines[k]);
    for (const sign of text) depth += "([{".includes(sign) ? 1 : ")]}".includes(sign) ? -1 : 0;
    if (depth <= 0) return text.trimEnd().endsWith(":") ? k : null;
  }
  return null;
}

/** A line without its comment nor what stands in its strings. */
function bare(text) {
  return text.replace(/"(?:[^"\\]|\\.)*"|'(?:[^'\\]|\\.)*'|#.*$/g, "");
}

export class Loops {
  #runs = new Map(); // of each frame: [{loop, from, to, laps}], `to` being the first step after it, or null

  constructor(trace) {
    this.trace = trace;
    this.loops = loopsOf(trace.lines);
  }

  /** The loops that a step is in, the innermost first: {line, laps (the steps at which each begins), lap (its place, −1 before the first), after}. */
  around(step) {
    const { frame, event } = this.trace.steps[step];
    if (event === "call" || this.loops.length === 0) return [];
    return this.#of(frame)
      .filter((run) => run.laps.length > 0 && run.from <= step && (run.to === null || step < run.to))
      .map(({ loop, laps, to }) => ({ line: loop.header, laps, lap: laps.findLastIndex((one) => one <= step), after: to }))
      .reverse();
  }

  #of(frame) {
    if (!this.#runs.has(frame)) this.#runs.set(frame, this.#counted(frame));
    return this.#runs.get(frame);
  }

  #counted(frame) {
    const { steps } = this.trace;
    const own = this.trace.own(frame).filter((step) => steps[step].event === "line");
    const runs = [];
    for (const loop of this.loops) {
      const inner = this.loops.find((one) => one.header === loop.first);
      let [run, before] = [null, null];
      for (const step of own) {
        const { line } = steps[step];
        const [heads, inside] = [line >= loop.header && line <= loop.ends, line >= loop.first && line <= loop.last];
        if (!heads && !inside) {
          if (run) run.to = step;
          run = null;
        } else if (!run && heads) runs.push((run = { loop, from: step, to: null, laps: [] }));
        if (run && inside && begins(loop, run, line, before, inner)) run.laps.push(step);
        before = line;
      }
      if (run) run.to = this.#over(frame, own.at(-1));
    }
    return runs.sort((a, b) => a.from - b.from || a.loop.header - b.loop.header);
  }

  /** The step of a call that comes after its last line, when there is one. */
  #over(frame, step) {
    return this.trace.own(frame).find((one) => one > step) ?? null;
  }
}

/** Whether a lap begins at a line of the body: one comes from the header or, where that is never asked again, from below. */
function begins(loop, run, line, before, inner) {
  if (before !== null && before >= loop.header && before <= loop.ends) return true;
  if (!loop.endless || run.laps.length === 0 || line !== loop.first) return false;
  return !(inner && before >= inner.header && before <= inner.last);
}
