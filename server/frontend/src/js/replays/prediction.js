// A question before the replay is played: what one said stands beside what happens, told once it has played to its end.

import { Said } from "../said.js";
import { button, lowered, make } from "./dom.js";

export class Prediction {
  #seen = false;

  /** `name` is that of the question in its module; `launch(settings)` plays the replay with these settings. */
  constructor(asked, name, figure, { launch }) {
    this.asked = asked;
    this.name = name;
    this.launch = launch;
    this.said = new Said(figure);
    this.answer = this.said.of(name);
    if (!this.#words(this.answer)) this.answer = undefined; // the question has changed since
    this.element = make("div", { class: "replay-prediction", "aria-live": "polite" });
    this.#show();
  }

  /** The replay has played to its end, with `settings`: the reader may know what happens. */
  ended(settings) {
    if (this.#seen || !same(settings, this.asked.settings)) return;
    this.#seen = true;
    if (this.answer) this.#show();
  }

  #words(id) {
    return this.asked.answers.find(([one]) => one === id)?.[1];
  }

  #show() {
    this.element.replaceChildren(...(this.answer ? this.#told() : [this.#form()]));
    this.element.classList.toggle("replay-prediction-told", Boolean(this.answer));
  }

  #form() {
    const group = `${this.name}-${Math.random().toString(36).slice(2)}`;
    const choices = this.asked.answers.map(([id, words]) =>
      make("label", {}, make("input", { type: "radio", name: group, value: id, required: true }), make("span", {}, ...lowered(words))),
    ); // prettier-ignore
    const send = make("button", { type: "submit", class: "button primary" }, this.#seen ? "Je réponds" : "Je parie, et je lance");
    const answered = (event) => {
      event.preventDefault();
      this.answer = new FormData(event.target).get(group);
      this.said.say(this.name, this.answer);
      this.#show();
      this.element.querySelector("[tabindex]").focus({ preventScroll: true });
      if (!this.#seen) this.launch(this.asked.settings);
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
    const { right, why, question } = this.asked;
    const mine = make("p", {}, make("b", {}, "Vous aviez dit : "), ...lowered(this.#words(this.answer)));
    const head = make("p", { class: "replay-prediction-asked", tabindex: "-1" }, ...lowered(question));
    if (!this.#seen) {
      const go = button("Lancer", () => this.launch(this.asked.settings));
      return [head, mine, make("p", { class: "replay-prediction-foot" }, go, make("span", { class: "soft" }, "Ce qui arrive s’affiche à la fin de l’animation."))];
    }
    const good = this.answer === right;
    mine.append(make("span", { class: good ? "replay-prediction-right" : "replay-prediction-wrong" }, good ? " ✓ c’est ce qui arrive" : " ✗ autre chose arrive"));
    const truth = make("p", {}, make("b", {}, "Ce qui arrive : "), ...(good ? [] : [...lowered(this.#words(right)), " "]), ...lowered(why));
    return [head, mine, truth];
  }
}

function same(settings, others) {
  const names = Object.keys(settings);
  return names.length === Object.keys(others).length && names.every((name) => settings[name] === others[name]);
}
