// Names proposed while one types: those of the exercise's page (`noms.json`) and those of the program itself. Nothing is
// chosen before an arrow was pressed, so that Enter and Tab stay what they were. A version of the package of its own
// (`?names`) keeps this out of what every editor loads; it shares no state with the closing of brackets.

import {
  acceptCompletion,
  autocompletion,
  closeCompletion,
  completionStatus,
  currentCompletions,
  moveCompletionSelection,
  selectedCompletionIndex,
  startCompletion,
} from "@codemirror/autocomplete?names";
import { syntaxTree } from "@codemirror/language";
import { EditorState, Prec, StateEffect } from "@codemirror/state";
import { EditorView, keymap, tooltips } from "@codemirror/view";
import { announce } from "./follow.js";

const LEAST = 2; // characters, before names are proposed unasked
const MOST = 30;
const NAME = /[\p{L}_][\p{L}\p{N}_]*/gu;
const TYPED = /[\p{L}_][\p{L}\p{N}_.]*/u;
const ASIDE = /#.*|("""|''')[^]*?\1|"[^"\n]*"|'[^'\n]*'/g;

/** Names are proposed in this editor from now on; at once where that was `asked` for. */
export async function begin(view, address, asked) {
  const names = await namesAt(address);
  const source = (context) => proposed(context, names);
  view.dispatch({
    effects: StateEffect.appendConfig.of([
      autocompletion({
        override: [source],
        selectOnOpen: false,
        defaultKeymap: false,
        icons: false,
        maxRenderedOptions: MOST,
        positionInfo: underOrOver,
      }),
      Prec.highest(keymap.of(KEYS)),
      tooltips({ tooltipSpace: seen }),
      EditorState.phrases.of({ Completions: "Noms proposés" }),
      EditorView.updateListener.of(tell()),
      look,
    ]),
  });
  if (asked) startCompletion(view);
}

async function namesAt(address) {
  try {
    const response = await fetch(address, { headers: { Accept: "application/json" } });
    if (response.ok) return (await response.json()).names;
    console.warn(`Les noms à proposer ne sont pas venus (${response.status}) ; ceux du programme restent.`);
  } catch (error) {
    console.warn("Les noms à proposer ne sont pas venus ; ceux du programme restent.", error);
  }
  return [];
}

// Where nothing is chosen the arrow up moves the caret, as always; the one down goes to the names. Escape is not used up:
// with Tab after it one leaves the editor.
const KEYS = [
  { key: "Ctrl-Space", run: startCompletion },
  { key: "Escape", run: (view) => closeCompletion(view) && false },
  { key: "ArrowDown", run: moveCompletionSelection(true) },
  { key: "ArrowUp", run: (view) => selectedCompletionIndex(view.state) !== null && moveCompletionSelection(false)(view) },
  { key: "Enter", run: acceptCompletion },
];

function proposed(context, names) {
  const typed = context.matchBefore(TYPED);
  const there = syntaxTree(context.state).resolveInner(context.pos, -1).name;
  if (!typed || there === "comment" || there === "string") return null;
  const dot = typed.text.lastIndexOf(".") + 1;
  const [owner, start] = [typed.text.slice(0, dot), typed.text.slice(dot)];
  if (!context.explicit && !dot && start.length < LEAST) return null;
  const options = [...known(names, owner), ...written(context.state, owner, names)].filter(
    ({ label }) => label !== start && label.toLowerCase().startsWith(start.toLowerCase()),
  );
  return options.length ? { from: typed.from + dot, options, filter: false } : null;
}

// Of `np.` its names; of nothing those that stand alone.
function known(names, owner) {
  return names
    .filter(({ name }) => name.startsWith(owner) && !name.slice(owner.length).includes("."))
    .map(({ name, signature, doc }) => ({ label: name.slice(owner.length), detail: signature, info: doc || undefined }));
}

function written(state, owner, names) {
  const code = state.doc.toString().replace(ASIDE, "");
  const there = new Set(names.map(({ name }) => name));
  const found = new Set();
  for (const { 0: word, index } of code.matchAll(NAME)) {
    const before = code.slice(Math.max(0, index - owner.length - 1), index);
    const fits = owner ? before.endsWith(owner) && !/[\p{L}\p{N}_.]/u.test(before.slice(0, -owner.length)) : !before.endsWith(".");
    if (fits && word.length > LEAST && !there.has(owner + word)) found.add(word);
  }
  return [...found].map((label) => ({ label }));
}

// What the keyboard of a phone and the bar of keys leave of the window.
function seen(view) {
  const { offsetLeft, offsetTop, width, height } = window.visualViewport;
  const bar = document.querySelector(".keys-above")?.offsetHeight ?? 0;
  return { left: offsetLeft, top: offsetTop, right: offsetLeft + width, bottom: offsetTop + height - bar };
}

// The line about a name stands under the list, or over it and the line of code: beside it would hide the statement.
function underOrOver(view, list, option, info, space) {
  const [height, width] = [list.bottom - list.top, Math.min(info.right - info.left, space.right - space.left)];
  const caret = view.coordsAtPos(view.state.selection.main.head);
  const line = caret && caret.top < list.top ? list.top - caret.top : 0;
  const side = space.bottom - list.bottom < info.bottom - info.top ? `bottom: ${height + line}px` : `top: ${height}px`;
  return { style: `${side}; left: ${Math.min(0, space.right - width - list.left)}px; max-width: ${width}px` };
}

// Said where they appear; how one takes them, the first time. What an arrow chooses the browser says.
function tell() {
  let [open, explained] = [false, false];
  return ({ state }) => {
    const opened = completionStatus(state) === "active";
    if (opened && !open) {
      const count = currentCompletions(state).length;
      announce(`${count > 1 ? `${count} noms proposés` : "Un nom proposé"}${explained ? "" : " : flèche bas pour choisir, Entrée pour prendre, Échap pour fermer"}`);
      explained = true;
    }
    open = opened;
  };
}

const look = EditorView.theme({
  ".cm-tooltip": { backgroundColor: "var(--surface)", color: "var(--ink)", border: "1px solid var(--line)" },
  ".cm-tooltip.cm-tooltip-autocomplete > ul": { fontFamily: "var(--mono)", maxWidth: "min(34rem, 92vw)", maxHeight: "12em" },
  ".cm-tooltip.cm-tooltip-autocomplete > ul > li": { padding: "0.2em 0.5em", lineHeight: "1.4" },
  ".cm-tooltip-autocomplete ul li[aria-selected]": { backgroundColor: "var(--accent)", color: "var(--on-accent)" },
  ".cm-completionDetail": { fontStyle: "normal", marginLeft: "0.4em", opacity: "0.8" },
  ".cm-completionInfo": { padding: "0.4em 0.6em", maxWidth: "22rem" },
});
