// Curves under the drawing: what is past stands out, what is to come is faint, and the cursor follows the frame.

import { css } from "./colours.js";
import { decimal, lowered, make, mark } from "./dom.js";

const HEIGHT = 132;
const MARGIN = { top: 8, right: 12, bottom: 20 };
const X_LABEL = 16;
const LINE = 15; // pixels between two labels, one under the other
const LEFT = 36; // at least, so that charts one above the other share their axis

export class Chart {
  constructor(data, seek) {
    this.canvas = make("canvas", { role: "img", "aria-label": data.title.replace(/_\{([^}]*)\}/g, " $1") });
    this.values = data.series.map(() => make("b", { "aria-hidden": "true" }));
    const keys = data.series.map((series, i) =>
      make("li", {}, swatch(series), make("span", {}, ...lowered(series.label)), this.values[i]),
    );
    this.height = HEIGHT + (data.xLabel ? X_LABEL : 0);
    this.canvas.style.height = `${this.height}px`;
    this.element = make(
      "div", { class: "replay-chart" },
      make("p", { class: "replay-chart-title" }, ...lowered(data.title)),
      make("ul", { class: "replay-keys", role: "list" }, ...keys),
      this.canvas,
    ); // prettier-ignore
    this.data = data;
    this.#followPointer(seek);
  }

  /** Take other data, if they go by the same names. */
  update(data) {
    const curves = ({ series }) => series.flatMap(({ label, style }) => [label, style]);
    const names = (one) => [one.title, one.xLabel, ...curves(one)].join("|");
    if (names(data) !== names(this.data)) return false;
    this.data = data;
    return true;
  }

  #followPointer(seek) {
    const go = (event) => {
      const px = event.clientX - this.canvas.getBoundingClientRect().left;
      const gaps = this.data.cursor.map((x) => Math.abs(this.plot.x(x) - px));
      seek(gaps.indexOf(Math.min(...gaps)));
    };
    this.canvas.addEventListener("pointerdown", (event) => {
      if (this.data.timeless) return;
      if (event.pointerType === "mouse") this.canvas.setPointerCapture(event.pointerId);
      go(event);
    });
    this.canvas.addEventListener("pointermove", (event) => {
      if (this.canvas.hasPointerCapture(event.pointerId)) go(event);
    });
  }

  paint(position, colours) {
    const ctx = this.canvas.getContext("2d");
    const density = window.devicePixelRatio || 1;
    const width = this.canvas.parentElement.clientWidth;
    const [wide, tall] = [Math.max(1, Math.round(width * density)), Math.round(this.height * density)];
    const { canvas } = this;
    if (wide !== canvas.width || tall !== canvas.height) [canvas.width, canvas.height] = [wide, tall];
    ctx.setTransform(density, 0, 0, density, 0, 0);
    ctx.clearRect(0, 0, width, this.height);
    ctx.font = `12px ${getComputedStyle(this.canvas).fontFamily}`;
    this.#layout(ctx, width);
    this.#axes(ctx, colours);
    const { cursor, series } = this.data;
    const index = Math.min(Math.floor(position), cursor.length - 1);
    const next = cursor[Math.min(index + 1, cursor.length - 1)];
    const now = cursor[index] + (position - index) * (next - cursor[index]);
    for (const one of series) this.#curve(ctx, one, colours, now);
    this.#lines(ctx, colours);
    this.#cursor(ctx, colours, now);
    series.forEach((one, i) => this.#say(i, one, cursor[index]));
  }

  #layout(ctx, width) {
    const xs = [...this.data.series.flatMap((one) => one.x), ...this.data.cursor];
    const ys = [...this.data.series.flatMap((one) => one.y), ...this.data.levels.map((one) => one.y)];
    const gap = this.data.series.some((one) => one.style === "bars") ? closest(xs) : 0;
    const [x0, x1] = widened(Math.min(...xs) - gap / 2, Math.max(...xs) + gap / 2);
    const whole = this.data.series.every((one) => one.x.every(Number.isInteger));
    const known = ys.filter((y) => y !== null && (!this.data.logarithmic || y > 0));
    const [low, high] = this.data.yRange;
    const [y0, y1] = widened(low ?? Math.min(...known), high ?? Math.max(...known) * 1.04);
    const level = this.data.logarithmic ? Math.log10 : (y) => y;
    const ticks = this.data.logarithmic ? powers(y0, y1) : nice(y0, y1, 4);
    const labels = ticks.map((tick) => written(tick, ticks));
    const left = Math.max(LEFT, ...labels.map((label) => 10 + ctx.measureText(label).width));
    const [right, bottom] = [width - MARGIN.right, this.height - MARGIN.bottom - (this.data.xLabel ? X_LABEL : 0)];
    const [from, to] = [level(y0), level(y1)];
    const least = this.data.logarithmic ? y0 : -Infinity;
    this.plot = {
      left, right, bottom, ticks, labels,
      bar: Math.min(36, Math.max(4, (0.5 * gap * (right - left)) / (x1 - x0))),
      xTicks: nice(x0, x1, Math.max(2, Math.floor((right - left) / 60)), whole ? 1 : 0),
      x: (x) => left + ((right - left) * (x - x0)) / (x1 - x0),
      y: (y) => bottom - ((bottom - MARGIN.top) * (level(Math.max(y, least)) - from)) / (to - from),
    }; // prettier-ignore
  }

  #axes(ctx, colours) {
    const { left, right, bottom, ticks, labels, xTicks, x, y } = this.plot;
    ctx.lineWidth = 1;
    ctx.fillStyle = css(colours.ink, 0.75);
    ctx.textBaseline = "middle";
    ctx.textAlign = "right";
    ticks.forEach((tick, i) => {
      ctx.strokeStyle = css(colours.faint, 0.7);
      stroke(ctx, [left, y(tick)], [right, y(tick)]);
      ctx.fillText(labels[i], left - 6, y(tick));
    });
    ctx.textAlign = "center";
    ctx.textBaseline = "top";
    for (const tick of xTicks) ctx.fillText(written(tick, xTicks), x(tick), bottom + 5);
    ctx.fillText(this.data.xLabel, (left + right) / 2, bottom + 20, right - left);
  }

  #curve(ctx, { x, y, color, style }, colours, now) {
    const side = style === "bars" ? this.plot.bar / 2 + 1 : 0; // the bar of this moment is whole
    for (const [from, to, opacity] of [[-Infinity, now, 1], [now, Infinity, this.data.timeless ? 1 : 0.22]]) {
      const [a, b] = [from, to].map((edge) => Math.min(Math.max(this.plot.x(edge) + side, -1e4), 1e4));
      ctx.save();
      ctx.beginPath();
      ctx.rect(a - (opacity < 1 ? 0 : 4), 0, b - a + (opacity < 1 ? 0 : 4), this.height);
      ctx.clip();
      ctx.strokeStyle = ctx.fillStyle = css(colours[color], opacity);
      ctx.lineWidth = 2;
      ctx.lineJoin = "round";
      if (style === "dashed") ctx.setLineDash([5, 4]);
      this.#trace(ctx, x, y, style);
      ctx.restore();
    }
  }

  #trace(ctx, x, y, style) {
    ctx.beginPath();
    let [down, last] = [false, 0];
    x.forEach((value, i) => {
      const [px, py] = [this.plot.x(value), y[i] === null ? NaN : this.plot.y(y[i])];
      if (style === "dots" && y[i] !== null) {
        ctx.moveTo(px + 2.5, py);
        ctx.arc(px, py, 2.5, 0, 2 * Math.PI);
      } else if (style === "bars" && y[i] !== null) {
        ctx.rect(px - this.plot.bar / 2, py, this.plot.bar, this.plot.bottom - py);
      } else if (y[i] !== null) {
        if (!down) ctx.moveTo(px, py);
        else if (style === "steps") ctx.lineTo(px, last);
        if (down) ctx.lineTo(px, py);
      }
      [down, last] = [y[i] !== null, py];
    });
    if (style === "dots" || style === "bars") ctx.fill();
    else ctx.stroke();
  }

  #lines(ctx, colours) {
    const { left, right, bottom, x, y } = this.plot;
    ctx.textBaseline = "bottom";
    for (const level of this.data.levels) {
      ctx.strokeStyle = ctx.fillStyle = css(colours[level.color], 0.8);
      ctx.setLineDash([2, 3]);
      stroke(ctx, [left, y(level.y)], [right, y(level.y)]);
      const base = y(level.y) - 2 < 14 ? y(level.y) + 16 : y(level.y) - 2;
      const far = this.#hides(right - ctx.measureText(level.label).width, right, base);
      ctx.textAlign = far ? "left" : "right";
      haloed(ctx, colours, level.label, far ? left + 4 : right, base);
    }
    const said = []; // where the labels of marks are, so that none lies on another
    for (const mark of this.data.marks) {
      const px = x(mark.x);
      ctx.strokeStyle = ctx.fillStyle = css(colours[mark.color]);
      ctx.setLineDash([4, 3]);
      stroke(ctx, [px, MARGIN.top], [px, bottom]);
      const [late, wide] = [px > (left + right) / 2, ctx.measureText(mark.label).width + 4];
      const [from, to] = late ? [px - wide, px] : [px, px + wide];
      const above = said.filter((one) => one.from < to && from < one.to).length;
      said.push({ from, to });
      ctx.textAlign = late ? "right" : "left";
      haloed(ctx, colours, mark.label, px + (late ? -4 : 4), MARGIN.top + 12 + LINE * above);
    }
    ctx.setLineDash([]);
  }

  /** Whether a label between two abscissas, standing on a line, would lie on a dot. */
  #hides(from, to, base) {
    const { x, y } = this.plot;
    const dots = this.data.series.filter((one) => one.style === "dots");
    const under = (px, py) => px > from - 6 && px < to + 6 && py > base - LINE - 3 && py < base + 3;
    return dots.some((one) => one.x.some((value, i) => one.y[i] !== null && under(x(value), y(one.y[i]))));
  }

  #cursor(ctx, colours, now) {
    ctx.strokeStyle = css(colours.ink, 0.6);
    ctx.lineWidth = 1.5;
    stroke(ctx, [this.plot.x(now), MARGIN.top - 4], [this.plot.x(now), this.plot.bottom]);
  }

  /** The value of a curve at the frame that is shown, beside its name. */
  #say(i, { x, y }, now) {
    const at = x.findLastIndex((value, k) => value <= now + 1e-9 && y[k] !== null);
    this.values[i].textContent = at < 0 ? "" : ` ${short(y[at])}`;
  }
}

function haloed(ctx, colours, words, x, y) {
  ctx.save();
  ctx.setLineDash([]);
  ctx.lineWidth = 4;
  ctx.strokeStyle = css(colours.surface, 0.85);
  ctx.strokeText(words, x, y);
  ctx.restore();
  ctx.fillText(words, x, y);
}

function stroke(ctx, from, to) {
  ctx.beginPath();
  ctx.moveTo(...from);
  ctx.lineTo(...to);
  ctx.stroke();
}

function swatch({ color, style }) {
  return mark({ dots: "dot", bars: "area", dashed: "dashed" }[style] ?? "line", color);
}

function widened(low, high) {
  return high > low ? [low, high] : [low, low + 1];
}

/** The least distance between two different numbers. */
function closest(xs) {
  const sorted = [...new Set(xs)].sort((a, b) => a - b);
  return sorted.length > 1 ? Math.min(...sorted.slice(1).map((x, i) => x - sorted[i])) : 1;
}

/** About `wanted` round numbers between two, `finest` apart at least. */
function nice(low, high, wanted, finest = 0) {
  const rough = Math.max((high - low) / wanted, finest);
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].find((one) => one * power >= rough) * power;
  const first = Math.ceil(low / step - 1e-9);
  return Array.from({ length: Math.floor(high / step + 1e-9) - first + 1 }, (_, i) => (first + i) * step);
}

function powers(low, high) {
  const [first, last] = [Math.ceil(Math.log10(low) - 1e-9), Math.floor(Math.log10(high) + 1e-9)];
  if (last - first < 1) return nice(low, high, 4);
  const step = Math.max(1, Math.ceil((last - first) / 4));
  return Array.from({ length: Math.floor((last - first) / step) + 1 }, (_, i) => 10 ** (first + i * step));
}

const SUPER = "⁰¹²³⁴⁵⁶⁷⁸⁹";

function written(tick, ticks) {
  if (Math.max(...ticks.map((one) => Math.abs(Math.log10(Math.abs(one) || 1)))) >= 4 && tick > 0) {
    const exponent = String(Math.round(Math.log10(tick))).replace("-", "⁻").replace(/\d/g, (digit) => SUPER[digit]);
    return `10${exponent}`;
  }
  const step = ticks.length > 1 ? Math.min(...ticks.slice(1).map((one, i) => Math.abs(one - ticks[i]))) : 1;
  return decimal(tick, Math.max(0, Math.min(4, -Math.floor(Math.log10(step) + 1e-9))));
}

function short(value) {
  const size = Math.abs(value);
  return decimal(value, size >= 100 || Number.isInteger(value) ? 0 : size >= 10 ? 1 : size >= 0.005 ? 2 : 4);
}
