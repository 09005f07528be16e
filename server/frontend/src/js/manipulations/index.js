// Manipulations of a page: each asks for what it starts from, and for its scripts, when it comes near the screen.
// What graders/scene/hands.py says of their folder is all that an author writes; here are the tools they share.

import { button, make } from "../replays/dom.js";
import { Bench } from "./bench.js";
import { load, Origin } from "./load.js";

export function enhance(root = document) {
  const watch = new IntersectionObserver(
    (entries) => {
      for (const { isIntersecting, target } of entries) {
        if (!isIntersecting) continue;
        watch.unobserve(target);
        begin(target);
      }
    },
    { rootMargin: "300px 0px" },
  );
  for (const figure of root.querySelectorAll("figure.manipulation[data-hands]:not([data-ready])")) {
    figure.dataset.ready = "";
    const place = figure.querySelector(".replay-stage");
    place.replaceChildren(make("div", { class: "replay-status", role: "status" }, "Préparation en cours…"));
    watch.observe(figure);
  }
}

async function begin(figure) {
  const place = figure.querySelector(".replay-stage");
  const address = figure.dataset.hands;
  try {
    const [scene, script] = await Promise.all([load(address), Origin.script(address)]);
    const bench = new Bench(place, address, scene);
    script.begin(bench, scene);
    figure.dataset.ready = "yes";
  } catch (error) {
    const again = button("Réessayer", () => begin(figure));
    const words = make("span", {}, `Cette manipulation n’a pas pu être préparée. ${error.message}`);
    place.replaceChildren(make("div", { class: "replay-status", role: "status" }, words, again));
  }
}
