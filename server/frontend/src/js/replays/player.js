// One replay: its data, the moment that is shown, and the passing of time.

import { Chart } from "./chart.js";
import { onThemeChange, readColours } from "./colours.js";
import { Settings, Transport } from "./controls.js";
import { button, lowered, make, mark } from "./dom.js";
import { Drag } from "./drag.js";
import { keepPlaces } from "./frames.js";
import { ALONE, GOALS, keysHelp } from "./keys.js";
import { Prediction, same } from "./prediction.js";
import { Source } from "./source.js";
import { Stage } from "./stage.js";

const STILL = window.matchMedia("(prefers-reduced-motion: reduce)");

export class Player {
  #position = 0;
  #playing = false;
  #speed = 1;
  #last = 0;
  #asked = false;
  #launched = false;

  constructor(figure) {
    this.figure = figure;
    this.canvas = make("canvas", { class: "replay-canvas", tabindex: "0", role: "img", "aria-keyshortcuts": ALONE });
    this.caption = make("p", { class: "replay-caption" });
    this.summary = make("div", { class: "replay-summary", "aria-live": "polite" });
    this.status = make("div", { class: "replay-status", role: "status" }, "Calcul en cours…");
    this.legend = make("ul", { class: "replay-keys", role: "list" });
    this.title = make("p", { class: "replay-title" });
    this.charts = make("div", { class: "replay-charts" });
    this.transport = new Transport({
      toggle: () => this.toggle(),
      step: (by) => this.seek(Math.round(this.#position) + by),
      seek: (to) => this.seek(to),
      speed: (to) => (this.#speed = to),
    });
    this.stage = new Stage(this.canvas);
    this.stages = [this.stage];
    this.astray = button("", () => this.seek(this.data.wrong[0]));
    this.drag = new Drag(this.stage, {
      moved: (name, pose) => this.settings.set(name, pose),
      held: (held) => this.summary.setAttribute("aria-busy", String(held)),
    });
    this.plots = [];
    this.source = new Source(figure.dataset.source, {
      answered: (data) => this.#take(data),
      failed: (error) => this.#fail(error),
      waiting: (waiting) => this.figure.classList.toggle("replay-waiting", waiting),
    });
    this.body = make("div", { class: "replay-body" });
    this.root = figure.querySelector(".replay-stage");
    this.root.replaceChildren(this.status, this.body);
    this.root.addEventListener("keydown", (event) => this.#key(event));
    new ResizeObserver(() => this.#resized()).observe(this.root);
    onThemeChange(() => this.#dress());
  }

  /** Called when the figure comes near the screen, and when it leaves it. */
  near(visible) {
    if (visible && !this.#asked) {
      this.#asked = true;
      this.source.ask({});
    }
    if (!visible) this.pause();
  }

  toggle() {
    if (this.#playing) {
      this.pause();
      return;
    }
    if (this.#position >= this.data.frames.length - 1) this.#position = 0;
    this.#playing = true;
    this.#last = performance.now();
    requestAnimationFrame((now) => this.#tick(now));
    this.#draw();
  }

  /** Plays from the beginning, with these settings. */
  launch(settings) {
    this.#playing = false;
    this.#launched = true;
    this.settings.take(settings);
    this.prediction.element.scrollIntoView({ block: "start" });
  }

  /** Shows how it begins with these settings, where the reader has others: a point is placed on that drawing. */
  #prepare(settings) {
    this.seek(0);
    if (!same(settings, this.settings.asked())) this.settings.take(settings);
  }

  pause() {
    if (!this.#playing) return;
    this.#playing = false;
    this.#position = Math.floor(this.#position + 1e-6);
    this.#draw();
  }

  seek(index) {
    this.#playing = false;
    const end = this.data.frames.length - 1;
    this.#position = Math.min(Math.max(index, 0), end);
    if (this.#position === end) this.prediction?.ended(this.settings.asked());
    this.#draw();
  }

  #tick(now) {
    if (!this.#playing) return;
    const end = this.data.frames.length - 1;
    const elapsed = Math.max(0, now - this.#last) / 1000; // the first time of a frame may lie before the button's
    this.#position = Math.min(end, this.#position + elapsed * (this.#speed / this.data.period));
    this.#last = now;
    if (this.#position >= end || document.hidden) this.#playing = false;
    if (this.#position >= end) this.prediction?.ended(this.settings.asked());
    this.#draw();
    if (this.#playing) requestAnimationFrame((next) => this.#tick(next));
  }

  #take(data) {
    const first = !this.data;
    keepPlaces(data.frames);
    const atEnd = first ? data.beginAtEnd : this.#position >= this.data.frames.length - 1;
    this.data = data;
    const last = data.frames.length - 1;
    this.#position = atEnd ? last : Math.min(this.#position, last);
    if (first) this.#build(data);
    this.summary.replaceChildren(...data.summary.map((text) => make("p", {}, ...lowered(text))));
    this.#showCharts(data.charts);
    this.#showLegend(data.legend);
    this.status.hidden = true;
    this.body.hidden = false;
    for (const stage of this.stages) stage.show(data);
    this.#watchPose(data);
    this.#draw();
    if (!this.#launched || this.source.waits) return;
    this.#launched = false;
    this.#position = 0;
    this.toggle();
  }

  #build(data) {
    this.settings = new Settings(data.parameters, data.values, {
      changed: (settings) => this.source.ask(settings),
      currentStep: () => this.#frame().step ?? this.#index(),
    });
    this.title.replaceChildren(...lowered(data.title));
    this.canvas.setAttribute("aria-label", data.alt);
    const several = Boolean(data.panels);
    this.view = make("div", { class: several ? "replay-view replay-several" : "replay-view" }, this.#drawings(data), this.caption);
    this.body.classList.toggle("replay-body-beside", !several && !this.settings.element.hidden);
    const { title, legend, view, transport, charts, settings, summary } = this;
    const turns = data.parameters.find((one) => one.kind === "pose")?.turns;
    const help = keysHelp(turns);
    this.prediction = this.#asks(data.prediction);
    const asked = this.prediction ? [this.prediction.element] : [];
    const head = make("div", { class: "replay-head" }, ...asked, title, legend);
    this.body.replaceChildren(head, view, transport.element, settings.element, charts, summary, help);
    if (data.wrong) {
      this.astray.textContent = data.wrong[1];
      transport.element.after(make("p", { class: "replay-astray" }, this.astray));
    }
    this.#dress();
  }

  #asks(prediction) {
    if (!prediction) return null;
    const name = this.figure.dataset.source.split("/").slice(2).join("/");
    return new Prediction(prediction, name, this.figure, this.stage, {
      launch: (settings) => this.launch(settings),
      prepare: (settings) => this.#prepare(settings),
      now: () => this.settings.asked(),
      draw: () => this.#draw(),
    });
  }

  /** The canvas, or one for each panel under its title; keys are pressed on the first. */
  #drawings({ panels = [] }) {
    if (panels.length === 0) return this.canvas;
    const drawings = panels.map((title, i) => {
      if (i > 0) {
        const canvas = make("canvas", { class: "replay-canvas", role: "img", "aria-label": title });
        this.stages.push(new Stage(canvas, i));
      }
      return make("div", {}, make("p", { class: "replay-panel" }, ...lowered(title)), this.stages[i].canvas);
    });
    return make("div", { class: "replay-panels" }, ...drawings);
  }

  #showCharts(charts) {
    if (this.plots.length === charts.length && charts.every((one, i) => this.plots[i].update(one))) return;
    this.plots = charts.map((one) => new Chart(one, (index) => this.seek(index)));
    this.charts.replaceChildren(...this.plots.map((plot) => plot.element));
    this.charts.classList.toggle("replay-charts-two", charts.length > 1);
  }

  #showLegend(legend) {
    const keys = legend.map(({ symbol, color, label }) =>
      make("li", {}, mark(symbol, color), make("span", {}, ...lowered(label))),
    );
    this.legend.replaceChildren(...keys);
  }

  #watchPose(data) {
    const layer = data.over.find((one) => one.drag);
    const parameter = layer && data.parameters.find((one) => one.name === layer.drag);
    if (!this.drag.wish) this.drag.watch(parameter ?? null, layer?.at);
    if (parameter) this.settings.tell(parameter.name, layer.at); // the robot does not always stand where it was put
  }

  #index() {
    return Math.min(Math.floor(this.#position + 1e-6), this.data.frames.length - 1);
  }

  #frame() {
    return this.data.frames[this.#index()];
  }

  #draw() {
    if (!this.data || !this.colours) return;
    const index = this.#index();
    const position = this.#playing && !STILL.matches ? this.#position : index;
    const wish = this.drag.wish;
    const ghost = wish ? [{ kind: "pose", at: wish, color: "ink", radius: 0.4, style: "ghost" }] : [];
    const placed = this.prediction?.layers(this.settings.asked()) ?? [];
    this.summary.hidden = this.charts.hidden = this.prediction?.hides(this.settings.asked()) ?? false;
    for (const stage of this.stages) stage.paint(position, this.colours, [...ghost, ...placed]);
    for (const plot of this.plots) plot.paint(position, this.colours);
    this.transport.show(index, this.data.frames.length, this.#playing);
    const words = this.#frame().caption;
    this.view.classList.toggle("replay-wrong", this.data.wrong?.[0] === index);
    if (this.words !== words) this.caption.replaceChildren(...lowered((this.words = words)));
  }

  #dress() {
    if (!this.root.isConnected) return; // another verdict has taken its place
    this.colours = readColours(this.root);
    this.#draw();
  }

  #resized() {
    if (this.data) for (const stage of this.stages) stage.resize();
    this.#draw();
  }

  #key(event) {
    if (event.altKey || event.ctrlKey || event.metaKey || !this.data) return;
    const { target } = event;
    const onCanvas = target === this.canvas;
    const slides = target.type === "range";
    if (onCanvas && this.drag.key(event)) event.preventDefault();
    else if (event.key === " ") {
      if (onCanvas || slides) this.#caught(event, () => this.toggle());
    } else if (onCanvas || (event.key.length === 1 && (slides || target.type === "button"))) {
      const goal = GOALS[event.key.length === 1 ? event.key.toLowerCase() : event.key];
      if (goal) this.#caught(event, () => this.seek(goal(this.#index(), this.data.frames.length - 1)));
    }
  }

  #caught(event, act) {
    event.preventDefault();
    act();
  }

  #fail(error) {
    const again = button("Réessayer", () => this.source.ask(this.settings?.asked() ?? {}));
    const words = make("span", {}, `Cette animation n’a pas pu être chargée. ${error.message}`);
    this.status.hidden = false;
    this.status.replaceChildren(words, again);
  }
}
