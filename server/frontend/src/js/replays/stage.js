// The drawing: a canvas that keeps the shape of the scene, sharp on every screen, and paints one moment of it.

import { css } from "./colours.js";
import { between, rows } from "./decode.js";
import { PAINTERS } from "./layers.js";

const COMFORTABLE = 560; // pixels of width from which dots and lines have their full size

export class Stage {
  /** `panel`: which drawing of a scene with several this is. */
  constructor(canvas, panel = 0) {
    this.canvas = canvas;
    this.panel = panel;
    this.context = canvas.getContext("2d");
    this.scene = null;
  }

  show(scene) {
    const [x0, y0, x1, y1] = scene.box;
    this.scene = scene;
    this.canvas.style.aspectRatio = `${x1 - x0} / ${y1 - y0}`;
    this.resize();
  }

  /** Fit the pixels to the place that the page leaves; true when anything changed. */
  resize() {
    const { width, height } = this.canvas.getBoundingClientRect();
    const density = window.devicePixelRatio || 1;
    const [wide, tall] = [Math.max(1, Math.round(width * density)), Math.max(1, Math.round(height * density))];
    const changed = wide !== this.canvas.width || tall !== this.canvas.height;
    if (changed) [this.canvas.width, this.canvas.height] = [wide, tall];
    if (this.scene) this.#measure(width, height, density);
    return changed;
  }

  #measure(width, height, density) {
    const { box, up } = this.scene;
    const [x0, y0, x1, y1] = box;
    const scale = Math.min(width / (x1 - x0), height / (y1 - y0));
    const [left, top] = [(width - scale * (x1 - x0)) / 2, (height - scale * (y1 - y0)) / 2];
    const zoom = Math.min(1, Math.max(0.65, width / COMFORTABLE));
    this.density = density;
    this.paper = {
      scale,
      zoom,
      turn: up ? -1 : 1,
      x: (x) => left + scale * (x - x0),
      y: (y) => top + scale * (up ? y1 - y : y - y0),
      back: (px, py) => [x0 + (px - left) / scale, up ? y1 - (py - top) / scale : y0 + (py - top) / scale],
    };
  }

  /** Paint the scene at `position`: a whole number is a frame, a part of one is on the way to the next. */
  paint(position, colours, extra = []) {
    if (!this.scene) return;
    const { layers, over, frames } = this.scene;
    const index = Math.min(Math.floor(position), frames.length - 1);
    const part = position - index;
    this.context.setTransform(this.density, 0, 0, this.density, 0, 0);
    this.context.fillStyle = css(colours.paper);
    this.context.fillRect(0, 0, this.canvas.width, this.canvas.height);
    for (const layer of layers) this.#one(layer, colours, count(layer, index, part));
    for (const layer of moment(frames, index, part)) this.#one(layer, colours, Infinity);
    for (const layer of over) this.#one(layer, colours, count(layer, index, part));
    for (const layer of extra) this.#one(layer, colours, Infinity);
  }

  #one(layer, colours, shown) {
    if ((layer.panel ?? this.panel) !== this.panel) return;
    this.context.save();
    PAINTERS[layer.kind](this.context, this.paper, layer, colours, shown);
    this.context.restore();
  }
}

/** How many of a standing layer's elements are shown; a line that grows does so smoothly. */
function count({ kind, until }, index, part) {
  if (!until) return Infinity;
  const now = until[index];
  const next = until[Math.min(index + 1, until.length - 1)];
  return kind === "polyline" ? now + part * (next - now) : now;
}

/** The layers of a frame, those that glide on their way to the next one. */
function moment(frames, index, part) {
  const { layers } = frames[index];
  if (part === 0 || index + 1 >= frames.length) return layers;
  const next = frames[index + 1].layers;
  const goes = (layer, i) => next[i]?.glide && next[i].kind === layer.kind;
  return layers.map((layer, i) => (goes(layer, i) ? glide(layer, next[i], part) : layer));
}

function glide(from, to, part) {
  if (Array.isArray(from.at)) {
    const angle = from.kind === "pose" ? 2 : 4;
    const row = (at) => ({ columns: at.length, values: at });
    return { ...from, at: [...between(row(from.at), row(to.at), part, angle).values] };
  }
  const name = from.kind === "rays" ? "ends" : "at";
  const moved = between(rows(from[name]), rows(to[name]), part);
  const turned = from.headings && between(rows(from.headings), rows(to.headings), part, 0);
  return { ...from, moved, turned };
}
