// CodeMirror over the text area, in a shadow tree: its styles are then adopted sheets, which a strict
// content security policy lets through without any exception.

import { closeBrackets, closeBracketsKeymap, insertBracket } from "@codemirror/autocomplete";
import {
  cursorCharLeft,
  cursorCharRight,
  cursorLineDown,
  cursorLineUp,
  defaultKeymap,
  history,
  historyKeymap,
  indentLess,
  indentMore,
  indentWithTab,
  undo,
} from "@codemirror/commands";
import {
  HighlightStyle,
  StreamLanguage,
  bracketMatching,
  foldKeymap,
  foldService,
  indentOnInput,
  indentUnit,
  syntaxHighlighting,
} from "@codemirror/language";
import { python } from "@codemirror/legacy-modes/mode/python";
import { EditorState, Prec, StateEffect, StateField } from "@codemirror/state";
import {
  Decoration,
  EditorView,
  drawSelection,
  highlightActiveLine,
  highlightActiveLineGutter,
  keymap,
  lineNumbers,
} from "@codemirror/view";
import { tags } from "@lezer/highlight";

// Colours are the page's own variables: they cross into the shadow tree and follow the theme by themselves.
const colours = HighlightStyle.define([
  { tag: [tags.keyword, tags.operatorKeyword, tags.modifier], color: "var(--code-keyword)" },
  { tag: [tags.string, tags.special(tags.string)], color: "var(--code-string)" },
  { tag: [tags.number, tags.bool, tags.null], color: "var(--code-number)" },
  { tag: [tags.comment], color: "var(--code-comment)", fontStyle: "italic" },
  { tag: [tags.definition(tags.variableName)], color: "var(--code-name)" },
  { tag: [tags.meta], color: "var(--code-name)" },
]);

const look = EditorView.theme({
  "&": { height: "100%", color: "var(--ink)", backgroundColor: "var(--code-back)", fontSize: "0.9375rem" },
  "&.cm-focused": { outline: "none" },
  ".cm-scroller": { fontFamily: "var(--mono)", lineHeight: "1.55" },
  ".cm-content": { caretColor: "var(--ink)", padding: "0.75rem 0" },
  ".cm-cursor": { borderLeftColor: "var(--ink)", borderLeftWidth: "2px" },
  ".cm-gutters": { backgroundColor: "var(--code-back)", color: "var(--ink-soft)", border: "none" },
  ".cm-lineNumbers .cm-gutterElement": { padding: "0 0.6rem 0 0.9rem" },
  ".cm-activeLine": { backgroundColor: "var(--code-line)" },
  ".cm-faultLine": { backgroundColor: "var(--bad-soft)", boxShadow: "inset 3px 0 0 var(--bad)" },
  ".cm-activeLineGutter": { backgroundColor: "var(--code-line)", color: "var(--ink)" },
  "&.cm-focused > .cm-scroller > .cm-selectionLayer .cm-selectionBackground, .cm-selectionBackground": {
    backgroundColor: "var(--code-selection)",
  },
  ".cm-selectionMatch": { backgroundColor: "var(--code-match)" },
  "&.cm-focused .cm-matchingBracket": { backgroundColor: "var(--code-match)", outline: "1px solid var(--accent)" },
  ".cm-panels": { backgroundColor: "var(--surface)", color: "var(--ink)", borderTop: "1px solid var(--line)" },
  ".cm-textfield, .cm-button": { font: "inherit", color: "inherit", background: "var(--back)", borderColor: "var(--line)" },
});

const phrases = EditorState.phrases.of({
  Find: "Chercher",
  Replace: "Remplacer",
  next: "suivant",
  previous: "précédent",
  all: "tout",
  "match case": "casse",
  "by word": "mot entier",
  regexp: "expression régulière",
  replace: "remplacer",
  "replace all": "tout remplacer",
  close: "fermer",
});

function submitKey(onSubmit) {
  const run = () => {
    onSubmit();
    return true;
  };
  return Prec.highest(keymap.of([{ key: "Mod-Enter", run }]));
}

// By the names that a bar of keys gives them.
const COMMANDS = {
  indent: indentMore,
  dedent: indentLess,
  left: cursorCharLeft,
  right: cursorCharRight,
  up: cursorLineUp,
  down: cursorLineDown,
  undo,
};

// Searching comes when it is asked for: few do, and all would wait for it.
const SEARCH_KEYS = ["Mod-f", "F3", "Mod-g", "Mod-d", "Mod-Alt-g", "Mod-Shift-l"];

function searchKeys() {
  const run = (key) => (view) => {
    import("./editor_search.js").then(({ begin }) => begin(view, key));
    return true;
  };
  return keymap.of(SEARCH_KEYS.map((key) => ({ key, run: run(key) })));
}

// What is indented more than its first line is folded with it.
const folds = foldService.of((state, start) => {
  const first = state.doc.lineAt(start);
  const depth = (line) => (line.text.trim() ? line.text.search(/\S/) : Infinity);
  let end = first.to;
  for (let number = first.number + 1; number <= state.doc.lines; number += 1) {
    const line = state.doc.line(number);
    if (depth(line) <= depth(first)) break;
    if (line.text.trim()) end = line.to;
  }
  return end > first.to ? { from: first.to, to: end } : null;
});

// The line of a fault, until the text changes.
const markFault = StateEffect.define();
const faultLine = StateField.define({
  create: () => Decoration.none,
  update(marks, transaction) {
    if (transaction.docChanged) return Decoration.none;
    for (const effect of transaction.effects) if (effect.is(markFault)) return effect.value;
    return marks;
  },
  provide: (field) => EditorView.decorations.from(field),
});

function faultAt(document, line) {
  if (line === null || line < 1 || line > document.lines) return Decoration.none;
  return Decoration.set([Decoration.line({ class: "cm-faultLine" }).range(document.line(line).from)]);
}

// `covered` tells how many pixels of the page's foot hide what is under them.
export function createEditor({ area, text, label, onChange, onSubmit, covered }) {
  const host = document.createElement("div");
  host.className = "editor-host";
  const shadow = host.attachShadow({ mode: "open" });
  area.after(host);

  const description = label ?? "Votre code Python. Tab indente ; Échap puis Tab pour sortir de l’éditeur ; Ctrl+Maj+Entrée va au verdict.";
  const state = EditorState.create({
    doc: text,
    extensions: [
      submitKey(onSubmit),
      lineNumbers(),
      highlightActiveLineGutter(),
      highlightActiveLine(),
      drawSelection(),
      history(),
      indentUnit.of("    "),
      EditorState.tabSize.of(4),
      indentOnInput(),
      bracketMatching(),
      closeBrackets(),
      searchKeys(),
      keymap.of([...closeBracketsKeymap, ...defaultKeymap, ...historyKeymap, ...foldKeymap, indentWithTab]),
      StreamLanguage.define(python),
      folds,
      EditorView.scrollMargins.of(() => (covered ? { bottom: covered() } : null)),
      syntaxHighlighting(colours),
      look,
      faultLine,
      phrases,
      EditorView.contentAttributes.of({ "aria-label": description, tabindex: "0", spellcheck: "false" }),
      EditorView.updateListener.of((update) => update.docChanged && onChange()),
    ],
  });
  const view = new EditorView({ state, root: shadow, parent: shadow });
  area.hidden = true;

  return {
    get: () => view.state.doc.toString(),
    set: (fresh) => view.dispatch({ changes: { from: 0, to: view.state.doc.length, insert: fresh } }),
    mark: (line) => view.dispatch({ effects: markFault.of(faultAt(view.state.doc, line)) }),
    insert: (typed) => view.dispatch(view.state.replaceSelection(typed)),
    command: (name) => COMMANDS[name](view),
    // As a key of the keyboard: a bracket or a quote comes with what closes it.
    type: (sign) => view.dispatch(insertBracket(view.state, sign) ?? view.state.replaceSelection(sign), { scrollIntoView: true }),
    // The caret goes to a place on the screen, where one is told.
    focus: ({ x, y } = {}) => {
      const at = x === undefined ? null : view.posAtCoords({ x, y });
      if (at !== null) view.dispatch({ selection: { anchor: at } });
      view.focus();
    },
  };
}

// Where there is a bar of keys: as editor.css, which hides it elsewhere.
export function onTouchWidth(action) {
  const touch = window.matchMedia("(max-width: 40rem), (pointer: coarse)");
  if (touch.matches) action();
  else touch.addEventListener("change", action, { once: true });
}
