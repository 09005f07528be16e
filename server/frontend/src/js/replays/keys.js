// The keys of a player: letters that AZERTY, QWERTZ and QWERTY have without another key, besides arrows, Home and End.

import { keyList, make } from "./dom.js";

/** Where each key leads, from the frame that is shown and the last one. */
export const GOALS = {
  p: (now) => now - 1,
  s: (now) => now + 1,
  r: () => 0,
  f: (_now, last) => last,
  ArrowLeft: (now) => now - 1,
  ArrowRight: (now) => now + 1,
  Home: () => 0,
  End: (_now, last) => last,
};

/** Those that lead there in every replay, as `aria-keyshortcuts` has them. */
export const ALONE = "Space P S R F";

const FRAMES = [
  ["Espace", "lire, ou mettre en pause"],
  ["P", "image précédente"],
  ["S", "image suivante"],
  ["R", "retour au début"],
  ["F", "fin"],
];

/** What the keys do, folded. `turns`: a pose can be moved on the drawing, and turned or not; undefined where there is none. */
export function keysHelp(turns) {
  const lines = [...FRAMES];
  if (turns === undefined) lines.push(["← →", "image précédente, image suivante"]);
  else lines.push(["← ↑ → ↓", "déplacer sur le dessin (avec Maj, plus vite)"]);
  if (turns) lines.push(["G D", "tourner à gauche, à droite"]);
  const where = "Le dessin étant choisi (touche Tab, ou un clic) ; les lettres valent aussi sur les boutons et les curseurs.";
  return make(
    "details", { class: "replay-help" },
    make("summary", {}, "Au clavier"),
    make("p", {}, where),
    keyList(lines),
  ); // prettier-ignore
}
