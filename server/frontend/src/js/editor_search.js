// Searching in the editor, with its panel and its keys.

import { highlightSelectionMatches, searchKeymap } from "@codemirror/search";
import { Prec, StateEffect } from "@codemirror/state";
import { keymap } from "@codemirror/view";

export function begin(view, key) {
  const added = [Prec.high(keymap.of(searchKeymap)), highlightSelectionMatches()];
  view.dispatch({ effects: StateEffect.appendConfig.of(added) });
  searchKeymap.find((one) => one.key === key)?.run(view);
}
