// The exercise page: draft, editor, submission without leaving the page, columns that can be resized.

import { inherited } from "./drafts.js";
import { followToVerdict, showWaiting } from "./follow.js";
import { reconciled, savesOf } from "./saves.js";
import { adopt, post, wayOn, withState } from "./send.js";
import { setUpSplitter } from "./splitter.js";
import { draftOfPage } from "./versions.js";

const form = document.getElementById("essai");
const area = document.getElementById("code");
const message = document.getElementById("essai-message");
const starter = document.getElementById("squelette").textContent.replace(/^\n/, "");
let editor = plainEditor();
const draft = draftOfPage(keyOf(form.dataset.account), {
  get: () => editor.get(),
  set: (text) => editor.set(text),
  again: () => editor.focus(),
});

const saves = savesOf(form, keyOf(form.dataset.account), {
  text: () => editor.get(),
  body: () => withState(form, new URLSearchParams({ code: editor.get() })),
});

function keyOf(account) {
  return `balise-brouillon:${account}:${form.dataset.exercise}`;
}

// What any editor offers; this one is the text area itself.
function plainEditor() {
  area.addEventListener("input", saveDraft);
  area.addEventListener("keydown", (event) => {
    if (event.key === "Enter" && !event.shiftKey && (event.ctrlKey || event.metaKey)) form.requestSubmit();
  });
  return {
    get: () => area.value,
    set: (text) => {
      area.value = text;
    },
    focus: () => area.focus(),
  };
}

function saveDraft() {
  document.getElementById("brouillon").textContent = draft.save() ? "Brouillon enregistré" : "";
  saves.changed();
}

async function setUpEditor() {
  const taken = form.dataset.taken === "true" ? area.value : null;
  const before = inherited(form.dataset.account, keyOf);
  const there = area.value;
  const text = reconciled(form, keyOf(form.dataset.account), draft, there);
  area.value = text;
  try {
    const { createEditor, onTouchWidth } = await import("./editor.js");
    let covered = () => 0;
    const options = { onChange: saveDraft, onSubmit: () => form.requestSubmit(), covered: () => covered() };
    editor = createEditor({ area, text: area.value, ...options });
    document.documentElement.classList.add("has-editor");
    onTouchWidth(async () => {
      const { setUpKeysBar } = await import("./keys_bar.js");
      covered = setUpKeysBar(form.querySelector(".editor"), editor);
    });
  } catch (error) {
    console.warn("L’éditeur n’a pas pu être chargé ; la zone de texte reste.", error);
  }
  // What was written before logging in, and code taken up again from an attempt, go above the draft: Ctrl+Z gives it back.
  if (before !== null) {
    editor.set(before);
    saveDraft();
  }
  if (taken !== null && taken !== (before ?? text)) editor.set(taken);
  if (taken !== null) {
    saveDraft();
    history.replaceState(null, "", location.pathname);
  }
  if (editor.get() !== there) saves.changed();
  draft.tellAnother();
}

function showMessage(text, step = null) {
  message.replaceChildren(text, ...(step ? [" ", step] : []));
  message.hidden = !text;
}

async function submit(event) {
  event.preventDefault();
  if (form.getAttribute("aria-busy") === "true") return;
  clearTimeout(nextTry);
  area.value = editor.get();
  showMessage("");
  busy(true);
  try {
    const accepted = await send();
    if (accepted) await followToVerdict(accepted);
  } finally {
    busy(false);
  }
}

function busy(state) {
  form.setAttribute("aria-busy", String(state));
  document.getElementById("envoyer").setAttribute("aria-disabled", String(state));
}

// The address of the accepted submission, or null after having said why there is none.
async function send() {
  const answer = await post(form.action, withState(form, new URLSearchParams({ code: area.value })), form.dataset.account);
  if (answer.accepted) {
    moveDraft(answer.accepted.account);
    showWaiting(answer.accepted.text);
    return answer.accepted;
  }
  const away = "Le serveur ne répond pas. Votre code est gardé ici : réessayez dans un instant.";
  if (answer.retryAfter) sendAgain(answer);
  else showMessage(answer.refusal ?? away, wayOn(form, answer.problem));
  return null;
}

let nextTry;

// Nothing was stored: what is in the editor then goes again, unless its author stops it.
function sendAgain({ refusal, retryAfter }) {
  const stop = document.createElement("button");
  stop.type = "button";
  stop.className = "button";
  stop.textContent = "Ne pas renvoyer";
  stop.addEventListener("click", () => {
    clearTimeout(nextTry);
    showMessage(refusal);
  });
  showMessage(`${refusal} Votre code est gardé ici, et sera renvoyé dans ${retryAfter} s.`, stop);
  nextTry = setTimeout(() => form.requestSubmit(), 1000 * retryAfter);
}

// A visitor becomes a guest at the first submission: the draft follows.
function moveDraft(account) {
  adopt(form, { account });
  draft.move(keyOf(account));
}

document.getElementById("recommencer").addEventListener("click", () => {
  if (!window.confirm("Revenir au code de départ ? Votre code actuel sera remplacé (Ctrl+Z le rend).")) return;
  editor.set(starter);
  saveDraft();
  editor.focus();
});

form.addEventListener("submit", submit);
for (const link of document.querySelectorAll(".skip[href='#code']")) {
  link.addEventListener("click", (event) => {
    event.preventDefault();
    editor.focus();
  });
}
for (const label of area.labels) label.addEventListener("click", () => editor.focus());
setUpEditor();
const own = document.getElementById("rejouer-un-appel");
own?.parentElement.addEventListener("toggle", () => import("./calls.js").then((calls) => calls.setUp(own, () => editor.get())), { once: true });
setUpSplitter(document.getElementById("cloison"));
