// The keys that move, copy, select and comment whole lines, once one of them was pressed. A version of the package of its
// own (`?lines`) keeps their commands out of what every editor loads; they share no state with those.

import { defaultKeymap, standardKeymap } from "@codemirror/commands?lines";
import { Prec, StateEffect } from "@codemirror/state";
import { keymap } from "@codemirror/view";

const usual = new Set(standardKeymap);
const keys = defaultKeymap.filter((binding) => !usual.has(binding));

export function begin(view, key) {
  view.dispatch({ effects: StateEffect.appendConfig.of(Prec.high(keymap.of(keys))) });
  keys.find((binding) => binding.key === key)?.run(view);
}
