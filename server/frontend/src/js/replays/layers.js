// One painter for each kind of layer. `paper` maps the scene to pixels: x(), y(), scale, turn (−1 where y grows up).

import { css, ramp } from "./colours.js";
import { cells, rows } from "./decode.js";

const TAU = 2 * Math.PI;
const pictures = new WeakMap();

function picture(layer, colours, shown) {
  const known = pictures.get(layer);
  if (known?.colours === colours && known.shown === shown) return known.canvas;
  const canvas = document.createElement("canvas");
  canvas.width = layer.w;
  canvas.height = layer.h;
  const context = canvas.getContext("2d");
  const image = context.createImageData(layer.w, layer.h);
  const table = ramp(layer.palette, colours);
  cells(layer).forEach((byte, i) => {
    if (byte <= shown) image.data.set(table.subarray(4 * byte, 4 * byte + 4), 4 * i);
  });
  context.putImageData(image, 0, 0);
  pictures.set(layer, { canvas, colours, shown });
  return canvas;
}

function grid(ctx, paper, layer, colours, shown) {
  const [left, low] = layer.corner;
  const [x, y] = [paper.x(left), paper.y(low)];
  const side = layer.cell * paper.scale;
  ctx.save();
  ctx.imageSmoothingEnabled = false;
  ctx.translate(x, y);
  ctx.scale(side, side * paper.turn);
  ctx.drawImage(picture(layer, colours, shown), 0, 0);
  ctx.restore();
}

const LEVELS = 8;

function points(ctx, paper, layer, colours, shown) {
  const at = layer.moved ?? rows(layer.at);
  const weights = layer.weights && rows(layer.weights).values;
  const headings = layer.headings && (layer.turned ?? rows(layer.headings)).values;
  const count = Math.min(at.count, shown);
  // Dots of one opacity are drawn together: thousands of single strokes would be slow.
  for (let level = 1; level <= LEVELS; level += 1) {
    const dots = new Path2D();
    const ticks = new Path2D();
    let any = false;
    for (let i = 0; i < count; i += 1) {
      const weight = weights ? weights[i] : 1;
      if (Math.max(1, Math.ceil(weight * LEVELS)) !== level) continue;
      any = true;
      const [x, y] = [paper.x(at.values[2 * i]), paper.y(at.values[2 * i + 1])];
      const radius = layer.size * paper.zoom * (weights ? 0.6 + 0.7 * weight : 1);
      dots.moveTo(x + radius, y);
      dots.arc(x, y, radius, 0, TAU);
      if (!headings) continue;
      const length = 3.2 * radius;
      ticks.moveTo(x, y);
      ticks.lineTo(x + length * Math.cos(headings[i]), y + paper.turn * length * Math.sin(headings[i]));
    }
    if (!any) continue;
    ctx.globalAlpha = weights ? 0.18 + 0.82 * (level / LEVELS) : layer.opacity;
    ctx.fillStyle = ctx.strokeStyle = css(colours[layer.color]);
    ctx.lineWidth = 1;
    ctx.stroke(ticks);
    ctx.fill(dots);
  }
}

function pose(ctx, paper, layer, colours) {
  const [x, y, angle] = layer.at;
  const radius = Math.max(9 * paper.zoom, layer.radius * paper.scale);
  ctx.translate(paper.x(x), paper.y(y));
  if (layer.label) {
    text(ctx, layer.label, 0, -radius - 9, colours, layer.color);
  }
  ctx.rotate(paper.turn * angle);
  ctx.lineWidth = 2;
  ctx.strokeStyle = css(colours[layer.color]);
  if (layer.style === "arrow") {
    ctx.beginPath();
    ctx.moveTo(-radius, 0);
    ctx.lineTo(radius, 0);
    ctx.moveTo(0.35 * radius, -0.5 * radius);
    ctx.lineTo(radius, 0);
    ctx.lineTo(0.35 * radius, 0.5 * radius);
    ctx.stroke();
    return;
  }
  if (layer.style === "target") {
    for (const part of [1, 0.45]) {
      ctx.beginPath();
      ctx.arc(0, 0, part * radius, 0, TAU);
      ctx.fillStyle = css(part < 1 ? colours[layer.color] : colours.paper, part < 1 ? 1 : 0.7);
      ctx.fill();
      ctx.stroke();
    }
    return;
  }
  ctx.beginPath();
  ctx.arc(0, 0, radius, 0, TAU);
  ctx.fillStyle = layer.style === "ghost" ? css(colours.paper, 0.35) : css(colours[layer.color]);
  ctx.fill();
  if (layer.style === "robot") {
    ctx.strokeStyle = css(colours.paper);
    ctx.stroke();
  } else {
    ctx.setLineDash([4, 3]);
    ctx.stroke();
    ctx.setLineDash([]);
  }
  ctx.beginPath();
  ctx.moveTo(0.15 * radius, -0.55 * radius);
  ctx.lineTo(0.8 * radius, 0);
  ctx.lineTo(0.15 * radius, 0.55 * radius);
  ctx.strokeStyle = layer.style === "ghost" ? css(colours[layer.color]) : css(colours.paper);
  ctx.lineJoin = "round";
  ctx.stroke();
}

function rays(ctx, paper, layer, colours, shown) {
  const ends = layer.moved ?? rows(layer.ends);
  const hits = rows(layer.hits).values;
  const [x, y] = [paper.x(layer.origin[0]), paper.y(layer.origin[1])];
  const count = Math.min(ends.count, shown);
  const [touching, lost, dots] = [new Path2D(), new Path2D(), new Path2D()];
  const radius = (count > 100 ? 2 : 3) * paper.zoom;
  for (let i = 0; i < count; i += 1) {
    const [endX, endY] = [paper.x(ends.values[2 * i]), paper.y(ends.values[2 * i + 1])];
    const path = hits[i] ? touching : lost;
    path.moveTo(x, y);
    path.lineTo(endX, endY);
    if (!hits[i]) continue;
    dots.moveTo(endX + radius, endY);
    dots.arc(endX, endY, radius, 0, TAU);
  }
  ctx.lineWidth = 1;
  ctx.strokeStyle = css(colours[layer.color], 0.45);
  ctx.stroke(touching);
  ctx.setLineDash([3, 4]);
  ctx.strokeStyle = css(colours.ink, 0.28);
  ctx.stroke(lost);
  ctx.setLineDash([]);
  ctx.fillStyle = css(colours[layer.color]);
  ctx.fill(dots);
}

function polyline(ctx, paper, layer, colours, shown) {
  const at = layer.moved ?? rows(layer.at);
  const count = Math.min(at.count, shown);
  const whole = Math.floor(count);
  ctx.beginPath();
  for (let i = 0; i < whole; i += 1) ctx.lineTo(paper.x(at.values[2 * i]), paper.y(at.values[2 * i + 1]));
  if (whole > 0 && whole < count) {
    const along = (axis) => {
      const from = at.values[2 * whole - 2 + axis];
      return from + (count - whole) * (at.values[2 * whole + axis] - from);
    };
    ctx.lineTo(paper.x(along(0)), paper.y(along(1)));
  }
  ctx.lineWidth = layer.width * paper.zoom;
  ctx.lineJoin = ctx.lineCap = "round";
  ctx.strokeStyle = css(colours[layer.color]);
  if (layer.dashed) ctx.setLineDash([6, 5]);
  ctx.stroke();
}

function segments(ctx, paper, layer, colours, shown) {
  const at = layer.moved ?? rows(layer.at);
  ctx.beginPath();
  for (let i = 0; i < 4 * Math.min(at.count, Math.floor(shown)); i += 4) {
    ctx.moveTo(paper.x(at.values[i]), paper.y(at.values[i + 1]));
    ctx.lineTo(paper.x(at.values[i + 2]), paper.y(at.values[i + 3]));
  }
  ctx.lineWidth = layer.width * paper.zoom;
  ctx.lineCap = "round";
  ctx.strokeStyle = css(colours[layer.color], layer.opacity);
  if (layer.dashed) ctx.setLineDash([5, 4]);
  ctx.stroke();
}

/** Filled rectangles, rows of left, bottom, right, top: the bars of a histogram. */
function boxes(ctx, paper, layer, colours) {
  const { values } = layer.moved;
  ctx.fillStyle = css(colours[layer.color], layer.opacity);
  for (let i = 0; i < values.length; i += 4) {
    const [x, y] = [paper.x(values[i]), paper.y(values[i + 1])];
    ctx.fillRect(x, y, paper.x(values[i + 2]) - x, paper.y(values[i + 3]) - y);
  }
}

function circles(ctx, paper, layer, colours, shown) {
  const at = layer.moved ?? rows(layer.at);
  for (let i = 0; i < Math.min(at.count, shown); i += 1) {
    ctx.beginPath();
    ctx.arc(paper.x(at.values[2 * i]), paper.y(at.values[2 * i + 1]), layer.radius * paper.scale, 0, TAU);
    rim(ctx, layer, colours, layer.filled);
  }
}

function ellipse(ctx, paper, layer, colours) {
  const [x, y, long, short, angle] = layer.at;
  ctx.beginPath();
  ctx.ellipse(
    paper.x(x), paper.y(y), long * paper.scale, short * paper.scale, paper.turn * angle, 0, TAU,
  ); // prettier-ignore
  rim(ctx, layer, colours, true);
}

function rim(ctx, layer, colours, filled) {
  ctx.fillStyle = css(colours[layer.color], 0.15);
  if (filled) ctx.fill();
  ctx.lineWidth = 1.5;
  ctx.strokeStyle = css(colours[layer.color]);
  ctx.stroke();
}

function labels(ctx, paper, layer, colours, shown) {
  const at = layer.moved ?? rows(layer.at);
  layer.texts.slice(0, shown).forEach((words, i) => {
    text(ctx, words, paper.x(at.values[2 * i]), paper.y(at.values[2 * i + 1]), colours, layer.color);
  });
}

function text(ctx, words, x, y, colours, color) {
  ctx.font = `600 12px ${getComputedStyle(ctx.canvas).fontFamily}`;
  ctx.textAlign = "center";
  ctx.textBaseline = "middle";
  ctx.lineWidth = 4;
  ctx.lineJoin = "round";
  ctx.strokeStyle = css(colours.paper, 0.85);
  ctx.strokeText(words, x, y);
  ctx.fillStyle = css(colours[color]);
  ctx.fillText(words, x, y);
}

export const PAINTERS = { grid, points, pose, rays, polyline, segments, boxes, circles, ellipse, labels };
