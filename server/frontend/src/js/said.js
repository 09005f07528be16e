// What one has answered to the questions of a lesson: kept on the server for whoever has an account, in this browser for
// a visitor, who takes it along on becoming somebody. The first answer is the one that stays.

import { headersFor } from "./send.js";
import { keep, recall } from "./storage.js";

const VISITOR = "visiteur";

export class Said {
  #page;

  /** `element` stands in the page of a lesson, or in none: then nothing is kept longer than the page. */
  constructor(element) {
    this.#page = element.closest("[data-said]");
    const [module] = (this.#page?.dataset.reading ?? "").split("/");
    this.module = module;
    this.key = `balise-dit:${module}`;
    this.known = parse(this.#page?.dataset.said);
  }

  get #hasAccount() {
    return this.#page && this.#page.dataset.account !== VISITOR;
  }

  /** What was said first, or nothing. */
  of(name) {
    if (this.known[name]) return this.known[name];
    const kept = parse(recall(this.key))[name];
    if (kept && this.#hasAccount) this.say(name, kept);
    return kept;
  }

  /** Keeps an answer. */
  async say(name, answer) {
    if (!this.#page) return;
    this.#keep(name, parse(recall(this.key))[name] ?? answer);
    if (!this.#hasAccount) return;
    const sent = await fetch(this.#page.dataset.answers, {
      method: "POST",
      headers: { "Content-Type": "application/json", ...headersFor(this.#page.dataset.account) },
      body: JSON.stringify({ question: name, answer }),
    }).catch(() => null); // it stays in the browser, and is sent when the page is opened again
    if (sent?.ok || sent?.status === 404 || sent?.status === 422) this.#keep(name, undefined);
  }

  #keep(name, answer) {
    keep(this.key, JSON.stringify({ ...parse(recall(this.key)), [name]: answer }));
  }
}

// What another version, or a curious reader, wrote there may be anything.
function parse(text) {
  try {
    const value = JSON.parse(text ?? "{}");
    return value && typeof value === "object" ? value : {};
  } catch {
    return {};
  }
}
