// A draft kept in the browser, under one key, by whatever tabs are open on the same exercise. A tab that finds there
// what another one has written does not write over it: its own version goes aside, and the reader chooses.

import { announce } from "./follow.js";
import { keep, recall } from "./storage.js";

const ASIDE = ":autre";

/** A draft with the notice of its page, `#versions`; `again` is called when the reader has chosen. */
export function draftOfPage(key, { get, set, again }) {
  const notice = document.getElementById("versions");
  const divided = (two) => {
    if (two && notice.hidden) announce(notice.querySelector("p").textContent);
    notice.hidden = !two;
  };
  const draft = new Draft(key, { get, set, divided });
  for (const [name, choose] of [["take", () => draft.takeOther()], ["keep", () => draft.keepThis()]]) {
    notice.querySelector(`[data-${name}]`).addEventListener("click", () => {
      choose();
      again();
    });
  }
  return draft;
}

class Draft {
  /** `get` and `set` reach what is written; `divided(true)` is called when there are two versions, and again at the end. */
  constructor(key, { get, set, divided }) {
    this.get = get;
    this.set = set;
    this.divided = divided;
    this.#open(key);
    window.addEventListener("storage", ({ key: changed, newValue: text }) => {
      if (changed === this.#slot) this.#look();
      const news = text !== null && text !== this.#refused && text !== this.get();
      if (changed === this.#other() && news) this.divided(true);
    });
    // A tab that slept has not been told.
    document.addEventListener("visibilitychange", () => document.hidden || this.#look());
  }

  #key;
  #slot;
  #known = null;
  #refused = null; // the version that the reader has not chosen: another tab may still hold it

  #open(key) {
    this.#key = key;
    this.#slot = key;
    this.#known = recall(key);
  }

  get kept() {
    return this.#known;
  }

  /** Says so when a version has stayed aside since another visit. */
  tellAnother() {
    const aside = recall(this.#key + ASIDE);
    if (aside !== null && aside !== this.#known) this.divided(true);
  }

  /** This text is the draft from now on; the one that was stays aside. */
  yieldTo(text) {
    if (this.#known !== null && this.#known !== text) keep(this.#key + ASIDE, this.#known);
    this.#write(text);
  }

  /** False where the browser keeps nothing. */
  save() {
    this.#look(); // this tab may not have been told of what another one has written
    return this.#write(this.get());
  }

  /** The same draft under another key: its author has an account now. */
  move(key) {
    if (key === this.#key) return;
    const [text, there] = [this.get(), recall(key)];
    keep(this.#slot, null);
    this.#open(key);
    if (there !== null && there !== text) this.#step();
    this.#write(text);
  }

  /** This version is the draft from now on, and no other is kept. */
  keepThis() {
    this.#refused = recall(this.#other());
    this.#settle();
  }

  takeOther() {
    const other = recall(this.#other());
    this.#refused = this.get();
    if (other !== null) this.set(other);
    this.#settle();
  }

  #look() {
    const stored = recall(this.#slot);
    if (stored === null || stored === this.#known) return;
    const [mine, drafted] = [this.get(), this.#known !== null];
    this.#known = stored;
    if (stored === mine) return;
    this.#step();
    if (drafted) this.#write(mine);
  }

  /** Aside, and leave the place to who has written there. */
  #step() {
    this.#slot = this.#other();
    this.divided(true);
  }

  #other() {
    return this.#slot === this.#key ? this.#key + ASIDE : this.#key;
  }

  #settle() {
    keep(this.#key + ASIDE, null);
    this.#slot = this.#key;
    this.#write(this.get());
    this.divided(false);
  }

  #write(text) {
    this.#known = text;
    return keep(this.#slot, text);
  }
}
