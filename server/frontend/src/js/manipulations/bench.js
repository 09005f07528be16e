// What a manipulation is made with: a drawing, handles on it, settings beside it, and words for what happens.

import { Chart } from "../replays/chart.js";
import { onThemeChange, readColours } from "../replays/colours.js";
import { Settings } from "../replays/controls.js";
import { button, decimal, lowered, make, mark } from "../replays/dom.js";
import { Stage } from "../replays/stage.js";
import { keep, recall } from "../storage.js";
import { Film } from "./film.js";
import { Handle } from "./handle.js";
import { load } from "./load.js";

const SAID_AFTER = 350; // milliseconds of rest after which what happened is read aloud

export class Bench {
  #layers = [];
  #asked = 0;
  #saying = 0;
  #turn = 0;

  // What an author's script may use without an import.
  tools = { button, decimal, keep, list, lowered, make, mark, recall };

  constructor(place, address, scene) {
    Object.assign(this, { place, address, scene });
    this.charts = [];
    this.handles = [];
    this.film = null;
    this.canvas = make("canvas", { class: "replay-canvas", role: "img", "aria-label": scene.alt });
    this.hands = make("div", { class: "hands", role: "group", "aria-label": "À prendre sur le dessin" });
    this.caption = make("div", { class: "replay-caption hands-said" });
    this.aloud = make("p", { class: "visually-hidden", role: "status" });
    this.legend = make("ul", { class: "replay-keys", role: "list" }, ...(scene.legend ?? []).map(key));
    this.sheet = make("div", { class: "hands-sheet" }, this.canvas, this.hands);
    this.view = make("div", { class: "replay-view" }, this.sheet, this.caption);
    this.side = make("div", { class: "hands-side" });
    const title = make("p", { class: "replay-title" }, ...lowered(scene.title));
    const both = make("div", { class: "hands-both" }, this.view, this.side);
    place.replaceChildren(make("div", { class: "replay-body replay-body-beside" }, title, this.legend, both, this.aloud));
    this.stage = new Stage(this.canvas);
    this.show(scene);
    this.colours = readColours(place);
    onThemeChange(() => place.isConnected && ((this.colours = readColours(place)), this.draw()));
    new ResizeObserver(() => this.#resized()).observe(this.sheet);
  }

  /** Show the rectangle of a scene, with the layers and the frames that it may have. */
  show({ box, up = false, layers = [], over = [], frames = [{ layers: [] }] }) {
    this.stage.show({ box, up, layers, over, frames });
  }

  /** The settings that the scene declares; `changed(values)` is called with the text of every one of them. A pose has
   * no field: a handle moves it. */
  settings(changed) {
    const defaults = Object.fromEntries(Object.entries(this.scene.values).map(([name, value]) => [name, written(value)]));
    const shown = this.scene.parameters.filter(({ kind }) => kind !== "pose");
    const told = (asked) => changed({ ...defaults, ...asked });
    const settings = new Settings(shown, this.scene.values, { changed: told, currentStep: () => 0 });
    this.side.append(settings.element);
    return { ...defaults };
  }

  /** Something to take hold of; see handle.js. */
  handle(options) {
    const made = new Handle(this, options);
    this.handles.push(made);
    return made;
  }

  remove(handle) {
    handle.element.remove();
    this.handles = this.handles.filter((one) => one !== handle);
  }

  /** A chart in the column beside; its `update(data)` takes new curves. */
  chart(data) {
    const made = new Chart({ levels: [], marks: [], yRange: [null, null], xLabel: "", timeless: true, logarithmic: false, ...data }, () => {});
    this.charts.push(made);
    this.side.append(made.element);
    return {
      update: (more) => {
        Object.assign(made.data, more);
        this.draw();
      },
    };
  }

  /** Layers to be drawn at the next frame of the screen; `colours` adds to those that have names. */
  paint(layers, colours = {}) {
    this.#layers = layers;
    this.extra = colours;
    this.draw();
  }

  draw() {
    if (this.#asked) return;
    this.#asked = requestAnimationFrame(() => {
      this.#asked = 0;
      this.#draw();
    });
  }

  #draw() {
    if (this.film) this.film.paint(this.stage, this.colours);
    else this.stage.paint(0, { ...this.colours, ...this.extra }, this.#layers);
    for (const chart of this.charts) chart.paint(0, this.colours);
  }

  #resized() {
    this.stage.resize();
    for (const handle of this.handles) handle.place();
    this.draw();
  }

  /** Words under the drawing; read aloud once the hand rests. `lines` are strings, or elements. */
  say(...lines) {
    this.caption.replaceChildren(...lines.map((line) => (typeof line === "string" ? make("p", {}, ...lowered(line)) : line)));
    clearTimeout(this.#saying);
    this.#saying = setTimeout(() => {
      this.aloud.textContent = this.caption.innerText;
    }, SAID_AFTER);
  }

  /** Have the server compute with these settings, then play what it answers on this drawing. */
  async run(settings, status) {
    const turn = (this.#turn += 1);
    status.textContent = "Calcul en cours…";
    try {
      const scene = await load(this.address, settings);
      if (turn !== this.#turn) return; // something newer was asked for
      status.textContent = "";
      const leaves = document.activeElement;
      this.stop();
      this.film = new Film(this, scene);
      this.show(scene);
      this.legend.replaceChildren(...scene.legend.map(key));
      this.caption.replaceChildren();
      this.view.append(this.film.caption, this.film.transport.element);
      this.side.append(this.film.summary, this.film.charts);
      this.place.classList.add("hands-playing");
      this.aloud.textContent = scene.summary.join(" ").replace(/_\{([^}]*)\}/g, " $1");
      this.#resized();
      if (leaves.checkVisibility?.() === false) this.film.transport.play.focus({ preventScroll: true });
      this.film.play();
    } catch (error) {
      if (turn === this.#turn) status.textContent = error.message;
    }
  }

  /** Back to what the hand does. */
  stop() {
    this.#turn += 1;
    if (!this.film) return;
    const { caption, transport, summary, charts } = this.film;
    for (const one of [caption, transport.element, summary, charts]) one.remove();
    this.film = null;
    this.place.classList.remove("hands-playing");
    this.legend.replaceChildren(...(this.scene.legend ?? []).map(key));
    this.show(this.scene.frames ? { ...this.scene, frames: [{ layers: [] }] } : this.scene);
    this.#resized();
  }
}

/** Points, or segments as rows of four numbers, in the form that painters take. */
function list(points) {
  return { columns: points[0]?.length ?? 2, count: points.length, values: Float64Array.from(points.flat()) };
}

function key({ symbol, color, label }) {
  return make("li", {}, mark(symbol, color), make("span", {}, ...lowered(label)));
}

function written(value) {
  return value === null ? "-1" : typeof value === "boolean" ? (value ? "1" : "0") : Array.isArray(value) ? value.join(",") : String(value);
}
