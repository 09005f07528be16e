// What the server computed from what was placed or drawn: its frames, one after the other, on the same drawing.

import { Chart } from "../replays/chart.js";
import { Transport } from "../replays/controls.js";
import { lowered, make } from "../replays/dom.js";
import { keepPlaces } from "../replays/frames.js";

const STILL = window.matchMedia("(prefers-reduced-motion: reduce)");

export class Film {
  #position = 0;
  #playing = false;
  #speed = 1;
  #last = 0;

  constructor(bench, scene) {
    Object.assign(this, { bench, scene });
    keepPlaces(scene.frames);
    this.caption = make("p", { class: "replay-caption" });
    this.transport = new Transport({
      toggle: () => (this.#playing ? this.pause() : this.play()),
      step: (by) => this.#seek(Math.round(this.#position) + by),
      seek: (to) => this.#seek(to),
      speed: (to) => (this.#speed = to),
    });
    this.plots = scene.charts.map((one) => new Chart(one, (index) => this.#seek(index)));
    this.charts = make("div", { class: this.plots.length > 1 ? "replay-charts replay-charts-two" : "replay-charts" }, ...this.plots.map((plot) => plot.element));
    this.summary = make("div", { class: "replay-summary" }, ...scene.summary.map((text) => make("p", {}, ...lowered(text))));
  }

  play() {
    if (this.#position >= this.scene.frames.length - 1) this.#position = 0;
    this.#playing = true;
    this.#last = performance.now();
    requestAnimationFrame((now) => this.#tick(now));
    this.bench.draw();
  }

  pause() {
    this.#playing = false;
    this.#position = Math.floor(this.#position + 1e-6);
    this.bench.draw();
  }

  #seek(index) {
    this.#playing = false;
    this.#position = Math.min(Math.max(index, 0), this.scene.frames.length - 1);
    this.bench.draw();
  }

  #tick(now) {
    if (!this.#playing || this.bench.film !== this) return;
    const end = this.scene.frames.length - 1;
    this.#position = Math.min(end, this.#position + (Math.max(0, now - this.#last) / 1000) * (this.#speed / this.scene.period));
    this.#last = now;
    if (this.#position >= end || document.hidden || !this.bench.place.isConnected) this.#playing = false;
    this.bench.draw();
    if (this.#playing) requestAnimationFrame((next) => this.#tick(next));
  }

  paint(stage, colours) {
    const index = Math.min(Math.floor(this.#position + 1e-6), this.scene.frames.length - 1);
    stage.paint(this.#playing && !STILL.matches ? this.#position : index, colours);
    for (const plot of this.plots) plot.paint(index, colours);
    this.transport.show(index, this.scene.frames.length, this.#playing);
    const words = this.scene.frames[index].caption;
    if (this.words !== words) this.caption.replaceChildren(...lowered((this.words = words)));
  }
}
