// What the reader goes through the steps with: buttons, the slider, the ways into and out of calls, the laps of loops.

import { button, icon, keyList, make } from "../replays/dom.js";
import { loopsOf } from "./loops.js";
import { callOf, counted } from "./words.js";

const ICONS = {
  first: "M7 5.5h2v13H7zM19 5.5v13L10.500 12z",
  last: "M15 5.5h2v13h-2zM5 5.5v13l8.5-6.5z",
  back: "M16 5.5v13L7.500 12z",
  on: "M8 5.5v13l8.500-6.5z",
};
const MOST_LOOPS = 2;

export class Controls {
  /** `go(step)`; `moves` of the trace; `rounding(exactly)` when the reader wants all the digits, or not any more. */
  constructor({ go, moves, now, rounding }) {
    Object.assign(this, { go, moves, now });
    this.buttons = {
      first: this.#pictured("Première étape (touche R)", ICONS.first, () => go(moves.first()), "R"),
      back: this.#pictured("Étape précédente (touche P ou ←)", ICONS.back, () => go(moves.by(now(), -1)), "P"),
      on: this.#pictured("Étape suivante (touche S ou →)", ICONS.on, () => go(moves.by(now(), 1)), "S", "Suivant"),
      last: this.#pictured("Dernière étape (touche F)", ICONS.last, () => go(moves.last()), "F"),
    };
    this.range = make("input", {
      type: "range", min: 0, max: 0, step: 1, value: 0, "aria-label": "Étape", "data-focus": "range",
      oninput: () => go(moves.open(now())[Number(this.range.value)]),
    }); // prettier-ignore
    this.counter = make("output", { class: "steps-counter" });
    this.exactly = make("input", { type: "checkbox", "data-focus": "exactly", onchange: () => rounding(this.exactly.checked) });
    this.exactness = make("label", { class: "steps-exactly" }, this.exactly, "Valeurs exactes");
    const { trace } = moves;
    const kept = trace.frames.length > 1 || loopsOf(trace.lines).length > 0;
    this.detours = make("div", { class: kept ? "steps-detours steps-detours-kept" : "steps-detours" });
    const { first, back, on, last } = this.buttons;
    this.element = make(
      "div", { class: "steps-controls", role: "group", "aria-label": "Étapes" },
      this.detours,
      this.range,
      make("div", { class: "steps-buttons" }, first, back, on, last, this.counter),
    ); // prettier-ignore
  }

  #pictured(title, path, onclick, key, words = "") {
    const face = words ? [make("span", {}, words), icon(path)] : [icon(path)];
    return make("button", { type: "button", class: words ? "button primary steps-on" : "steps-go", title, "aria-label": title.replace(/ \(.*/, ""), "aria-keyshortcuts": key, "data-focus": `go:${key}`, onclick }, ...face);
  }

  show(step, loops) {
    const open = this.moves.open(step);
    const place = this.moves.place(step);
    this.range.max = String(open.length - 1);
    this.range.value = String(place);
    this.range.setAttribute("aria-valuetext", `étape ${place + 1} sur ${open.length}, ligne ${this.moves.trace.steps[step].line}`);
    this.counter.textContent = `${place + 1} / ${open.length}`;
    for (const [name, ends] of [["first", 0], ["back", 0], ["on", open.length - 1], ["last", open.length - 1]])
      this.buttons[name].setAttribute("aria-disabled", String(place === ends));
    this.detours.replaceChildren(...this.#calls(step), ...loops.slice(0, MOST_LOOPS).map((one) => this.#laps(one)));
  }

  #calls(step) {
    const { trace } = this.moves;
    const [into, out] = [this.moves.into(step), this.moves.out(step)];
    const ways = [];
    if (into !== null) {
      const words = `Entrer dans ${callOf(trace, trace.steps[into].frame)} (${counted(this.moves.size(into), "étape")})`;
      ways.push(this.#way("into", words, "E", () => this.go(into)));
    }
    if (out !== null) ways.push(this.#way("out", `Sortir de ${callOf(trace, trace.steps[step].frame)}`, "O", () => this.go(out)));
    return ways.length > 0 ? [make("div", { class: "steps-ways" }, ...ways)] : [];
  }

  #way(name, words, key, onclick) {
    return make("button", { type: "button", class: "button steps-way", "aria-keyshortcuts": key, title: `Touche ${key}`, "data-focus": name, onclick }, words);
  }

  /** « Boucle ligne 7, tour 3 sur 37 », and the ways to other laps. */
  #laps({ line, laps, lap, after }) {
    const id = `steps-lap-${line}`;
    const to = (place) => () => this.go(laps[Math.min(Math.max(place, 0), laps.length - 1)]);
    const link = (words, sign, onclick, off) => {
      const look = { type: "button", class: "link-button", title: words, "data-focus": `lap:${line}:${words}`, "aria-disabled": String(off) };
      const face = [make("span", { class: "steps-lap-word" }, words), make("span", { class: "steps-lap-sign", "aria-hidden": "true" }, sign)];
      return make("button", { ...look, onclick: off ? () => {} : onclick }, ...face);
    };
    const number = make("input", {
      type: "number", id, min: 1, max: laps.length, value: lap < 0 ? "" : lap + 1, inputmode: "numeric", "data-focus": `lap:${line}:number`,
      onchange: () => Number(number.value) >= 1 && to(Math.round(Number(number.value)) - 1)(),
    }); // prettier-ignore
    const skip = after === null ? [] : [link("passer la boucle", "⤓", () => this.go(after), false)];
    return make(
      "div", { class: "steps-laps", role: "group", "aria-label": `Boucle de la ligne ${line}` },
      make("label", { for: id }, `Boucle ligne ${line}`, make("span", { class: "steps-lap-word" }, "\u00a0: tour")), number, make("span", {}, `sur\u00a0${laps.length}`),
      link("premier", "⇤", to(0), lap === 0), link("précédent", "←", to(lap - 1), lap <= 0),
      link("suivant", "→", to(lap + 1), lap === laps.length - 1), link("dernier", "⇥", to(laps.length - 1), lap === laps.length - 1), ...skip,
    ); // prettier-ignore
  }
}

const KEYS = [
  ["S →", "étape suivante"],
  ["P ←", "étape précédente"],
  ["R", "retour au début"],
  ["F", "fin"],
  ["E", "entrer dans l’appel"],
  ["O", "en sortir"],
  ["T", "tour suivant de la boucle"],
  ["X", "valeurs exactes, ou arrondies"],
  ["↑ ↓", "dans le code, choisir une ligne ; Entrée va à son passage suivant"],
  ["Échap", "fermer"],
];

/** What the keys and clicks do, folded. */
export function help() {
  const clicks = "Un clic sur le nom d’une variable va là où elle change ensuite (avec Maj, là où elle changeait avant) ; un clic sur le numéro d’une ligne, à son passage suivant.";
  return make(
    "details", { class: "steps-help" },
    make("summary", { "data-focus": "help" }, "Au clavier et à la souris"), keyList(KEYS), make("p", {}, clicks),
  ); // prettier-ignore
}
