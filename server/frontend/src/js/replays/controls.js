// What the reader acts with: the buttons of the player, and the settings that the replay declares.

import { button, decimal, icon, lowered, make } from "./dom.js";

const ICONS = {
  play: "M7 4.5v15l13-7.5z",
  pause: "M7 5h4v14H7zM14 5h4v14h-4z",
  back: "M17.5 5.5v13L8.5 12zM6 5.5h2v13H6z",
  on: "M6.5 5.5v13l9-6.5zM16 5.5h2v13h-2z",
};
const SPEEDS = [0.25, 0.5, 1, 2, 4];
const SHORT = 22; // characters of a choice that the narrowest column shows whole

export class Transport {
  constructor({ toggle, step, seek, speed }) {
    this.play = make("button", { type: "button", class: "replay-play", onclick: toggle });
    this.range = make("input", {
      type: "range", min: 0, max: 0, step: 1, value: 0, "aria-label": "Image",
      oninput: () => seek(Number(this.range.value)),
    }); // prettier-ignore
    this.counter = make("output", { class: "replay-counter" });
    const speeds = SPEEDS.map((one) =>
      make("option", { value: one, selected: one === 1 }, `× ${String(one).replace(".", ",")}`),
    );
    const select = make("select", { "aria-label": "Vitesse", onchange: () => speed(Number(select.value)) }, ...speeds);
    this.element = make(
      "div", { class: "replay-transport" },
      pictured("Image précédente", ICONS.back, () => step(-1)),
      this.play,
      pictured("Image suivante", ICONS.on, () => step(1)),
      this.range, this.counter, select,
    ); // prettier-ignore
    this.show(0, 1, false);
  }

  show(index, frames, playing) {
    if (this.playing !== playing) {
      this.playing = playing;
      this.play.replaceChildren(icon(playing ? ICONS.pause : ICONS.play));
      this.play.setAttribute("aria-label", playing ? "Pause" : "Lecture");
      this.play.title = playing ? "Pause" : "Lecture";
    }
    this.range.max = String(frames - 1);
    this.range.value = String(index);
    this.range.setAttribute("aria-valuetext", `image ${index + 1} sur ${frames}`);
    this.counter.textContent = `${index + 1} / ${frames}`;
  }
}

function pictured(label, path, onclick) {
  const look = { class: "replay-step", "aria-label": label, title: label };
  return make("button", { type: "button", ...look, onclick }, icon(path));
}

/** The settings. `changed` is called with all of them, `{name: text}`, those left at their defaults aside. */
export class Settings {
  #defaults = {};
  #values = {};
  #shown = {};
  #conditions = [];

  constructor(parameters, values, { changed, currentStep }) {
    this.changed = changed;
    this.currentStep = currentStep;
    this.#defaults = Object.fromEntries(parameters.map(({ name }) => [name, asText(values[name])]));
    this.#values = { ...this.#defaults };
    this.reset = button("Réglages de départ", () => this.take({}), "link-button");
    const fields = parameters.map((one) => this.#conditional(one, this.#field(one))).filter(Boolean);
    this.element = make("div", { class: "replay-settings", hidden: fields.length === 0 }, ...fields, this.reset);
    this.#refresh();
  }

  /** Set one value from outside: the robot that was dragged. */
  set(name, value) {
    this.#values[name] = asText(value);
    this.#refresh();
    this.changed(this.asked());
  }

  /** Set all of them: `{name: text}`, defaults elsewhere. */
  take(settings) {
    this.#values = { ...this.#defaults, ...settings };
    this.#refresh();
    this.changed(this.asked());
  }

  asked() {
    return Object.fromEntries(Object.entries(this.#values).filter(([name, text]) => text !== this.#defaults[name]));
  }

  /** Show another value than the one that was asked for: what the server made of it. */
  tell(name, value) {
    this.#shown[name](asText(value));
  }


  #refresh() {
    for (const [name, text] of Object.entries(this.#values)) this.#shown[name]?.(text);
    for (const [field, needs] of this.#conditions) {
      field.hidden = needs.some(([name, values]) => !values.includes(this.#values[name]));
    }
    this.reset.hidden = Object.keys(this.asked()).length === 0;
  }

  /** A setting that acts only with some values of others is shown with these alone. */
  #conditional({ onlyWith }, field) {
    if (onlyWith) this.#conditions.push([field, Object.entries(onlyWith)]);
    return field;
  }

  #field(parameter) {
    const id = `replay-${crypto.randomUUID?.() ?? Math.random().toString(36).slice(2)}`;
    switch (parameter.kind) {
      case "slider": return this.#slider(parameter, id);
      case "choice": return this.#choice(parameter, id);
      case "switch": return this.#switch(parameter, id);
      case "event": return this.#event(parameter);
      case "draw": return this.#draw(parameter);
      case "pose": return this.#pose(parameter);
    } // prettier-ignore
  }

  #slider({ name, label, least, most, step, unit, decimals }, id) {
    const output = make("output", { for: id });
    const words = (text) => `${decimal(Number(text), decimals)}${suffix(unit, Number(text))}`;
    const bounds = { min: least, max: most, step };
    const input = make("input", { type: "range", id, ...bounds, oninput: () => this.set(name, input.value) });
    this.#shown[name] = (text) => {
      if (input.value !== text) input.value = text;
      output.textContent = words(text);
      input.setAttribute("aria-valuetext", words(text));
    };
    return make("div", { class: "replay-field" }, make("label", { for: id }, ...lowered(label)), output, input);
  }

  #choice({ name, label, options }, id) {
    const select = make("select", { id, onchange: () => this.set(name, select.value) });
    select.append(...options.map(([value, words]) => make("option", { value }, words)));
    this.#shown[name] = (text) => (select.value = text);
    const long = options.some(([, words]) => words.length > SHORT);
    return make("div", { class: long ? "replay-field replay-wide" : "replay-field" }, make("label", { for: id }, ...lowered(label)), select);
  }

  #switch({ name, label }, id) {
    const flip = () => this.set(name, input.checked);
    const input = make("input", { type: "checkbox", id, role: "switch", onchange: flip });
    this.#shown[name] = (text) => (input.checked = text === "1");
    return make("div", { class: "replay-field replay-switch" }, input, make("label", { for: id }, ...lowered(label)));
  }

  #event({ name, label, undo, steps }) {
    const press = () => this.set(name, this.#values[name] === "-1" ? Math.min(this.currentStep(), steps - 1) : -1);
    const element = button("", press);
    this.#shown[name] = (text) => (element.textContent = text === "-1" ? label : undo);
    return make("div", { class: "replay-field replay-action" }, element);
  }

  #draw({ name, label, count }) {
    const press = () => this.set(name, (Number(this.#values[name]) + 1) % count);
    return make("div", { class: "replay-field replay-action" }, button(label, press));
  }

  #pose({ name, label, turns }) {
    const output = make("output", {});
    this.#shown[name] = (text) => {
      const [x, y, angle] = text.split(",").map(Number);
      const heading = turns ? `, θ = ${decimal((angle * 180) / Math.PI, 0)}°` : "";
      output.textContent = `x = ${decimal(x, 2)}, y = ${decimal(y, 2)}${heading}`;
    };
    const keys = (...names) => names.flatMap((one) => [make("kbd", {}, one), " "]);
    const help = make("span", { class: "help" }, "À tirer sur le dessin, ou avec les touches ");
    help.append(...keys("←", "↑", "→", "↓"));
    if (turns) help.append("; pour l’orienter, tirez sa pointe, ou touches ", ...keys("G"), "(gauche) et ", ...keys("D"), "(droite)");
    const title = make("span", { class: "replay-name" }, label);
    return make("div", { class: "replay-field replay-pose" }, title, output, help);
  }
}

function asText(value) {
  if (value === null) return "-1";
  if (typeof value === "boolean") return value ? "1" : "0";
  return Array.isArray(value) ? value.map((one) => String(Number(one.toFixed(6)))).join(",") : String(value);
}

function suffix(unit, value) {
  if (unit === "°" || unit === "") return unit;
  return `\u00a0${unit === "case" && Math.abs(value) >= 2 ? "cases" : unit}`;
}
