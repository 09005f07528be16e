// A question before the replay is played, or a point to place on it: what one said stands beside what happens, told once
// it has played to its end.

import { Said } from "../said.js";
import { button, lowered, make } from "./dom.js";
import { Place } from "./place.js";

export class Prediction {
  #seen = false;
  #ready = false;

  /**
   * `name` is that of the question in its module; `launch(settings)` plays the replay with these settings,
   * `prepare(settings)` shows its first frame, `now()` tells the settings that it has, `draw()` draws again.
   */
  constructor(asked, name, figure, stage, { launch, prepare, now, draw }) {
    Object.assign(this, { asked, name, launch, draw });
    const first = () => {
      if (this.#ready && same(now(), asked.settings)) return;
      this.#ready = true;
      prepare(asked.settings);
    };
    this.place = asked.place ? new Place(asked.place, stage, { changed: draw, prepare: first }) : null;
    this.said = new Said(figure);
    this.caption = figure.querySelector("figcaption");
    this.answer = this.said.of(name);
    if (!this.#words(this.answer)) this.answer = undefined; // the question has changed since
    if (this.place && this.answer) this.place.at = this.place.read(this.answer);
    this.element = make("div", { class: "replay-prediction", "aria-live": "polite" });
    this.#show();
  }

  /** The replay has played to its end, with `settings`: the reader may know what happens. */
  ended(settings) {
    if (this.#seen || !same(settings, this.asked.settings)) return;
    this.#seen = true;
    if (this.answer) this.#show();
    else this.#fold();
  }

  /** What it adds to the drawing of these settings, on which it was asked. */
  layers(settings) {
    if (!this.place || !same(settings, this.asked.settings)) return [];
    return this.place.layers(this.#seen && Boolean(this.answer));
  }

  /** Whether what comes of these settings may not be told yet, neither in words nor by curves: one has not answered. */
  hides(settings) {
    const open = this.place ? this.place.open : !this.answer;
    return Boolean(open) && !this.#seen && same(settings, this.asked.settings);
  }

  #words(answer) {
    if (!this.place) return this.asked.answers.find(([one]) => one === answer)?.[1];
    const at = this.place.read(answer);
    return at && this.place.words(at);
  }

  #show() {
    this.element.replaceChildren(...(this.answer ? this.#told() : [this.#form()]));
    this.element.classList.toggle("replay-prediction-told", Boolean(this.answer));
    this.#fold();
  }

  /** The text below says what happens, or nearly: it is folded until one has answered, or seen it. */
  #fold() {
    const folded = this.caption?.querySelector(":scope > .replay-guide");
    if (this.answer || this.#seen) folded?.replaceWith(...[...folded.childNodes].slice(1));
    else if (this.caption && !folded) {
      const words = [...this.caption.childNodes];
      const title = make("summary", {}, "Ce que l’on peut y essayer, et y voir");
      this.caption.append(make("details", { class: "replay-guide" }, title, ...words));
    }
  }

  #form() {
    const group = `${this.name}-${Math.random().toString(36).slice(2)}`;
    const choices = this.place
      ? [this.place.fields()]
      : this.asked.answers.map(([id, words]) =>
          make("label", {}, make("input", { type: "radio", name: group, value: id, required: true }), make("span", {}, ...lowered(words))),
        ); // prettier-ignore
    const send = make("button", { type: "submit", class: "button primary" }, this.#seen ? "Je réponds" : "Je parie, et je lance");
    const answered = (event) => {
      event.preventDefault();
      if (this.place && !this.place.at) return;
      this.answer = this.place ? this.place.text : new FormData(event.target).get(group);
      if (this.place) this.place.open = false;
      this.said.say(this.name, this.answer);
      this.#show();
      this.element.querySelector("[tabindex]").focus({ preventScroll: true });
      if (!this.#seen) this.launch(this.asked.settings);
      else this.draw();
    };
    return make(
      "form", { onsubmit: answered },
      make(
        "fieldset", {},
        make("legend", {}, make("b", {}, "Avant de regarder. "), ...lowered(this.asked.question)),
        ...choices,
      ),
      make("p", { class: "replay-prediction-foot" }, send, make("span", { class: "soft" }, "Sans note. On peut aussi lire l’animation sans répondre.")),
    ); // prettier-ignore
  }

  #told() {
    const { why, question } = this.asked;
    const said = this.place ? "Vous aviez placé le point en " : "Vous aviez dit : ";
    const mine = make("p", {}, make("b", {}, said), ...lowered(this.#words(this.answer)));
    const head = make("p", { class: "replay-prediction-asked", tabindex: "-1" }, ...lowered(question));
    if (!this.#seen) {
      const go = button("Lancer", () => this.launch(this.asked.settings));
      return [head, mine, make("p", { class: "replay-prediction-foot" }, go, make("span", { class: "soft" }, "Ce qui arrive s’affiche à la fin de l’animation."))];
    }
    const { good, words, truth } = this.#verdict();
    mine.append(make("span", { class: good ? "replay-prediction-right" : "replay-prediction-wrong" }, words));
    return [head, mine, make("p", {}, make("b", {}, "Ce qui arrive : "), ...truth, ...lowered(why))];
  }

  #verdict() {
    const { right } = this.asked;
    if (this.place) {
      const verdict = this.place.verdict(this.place.at);
      return { ...verdict, truth: [] };
    }
    const good = this.answer === right;
    const truth = good ? [] : [...lowered(this.#words(right)), " "];
    return { good, words: good ? " ✓ c’est ce qui arrive" : " ✗ autre chose arrive", truth };
  }
}

export function same(settings, others) {
  const names = Object.keys(settings);
  return names.length === Object.keys(others).length && names.every((name) => settings[name] === others[name]);
}
