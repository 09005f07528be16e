// The exercise page: draft, editor, submission without leaving the page, columns that can be resized.

import { announce, followToVerdict, showWaiting } from "./follow.js";
import { setUpSplitter } from "./splitter.js";
import { keep, recall } from "./storage.js";

const form = document.getElementById("essai");
const area = document.getElementById("code");
const message = document.getElementById("essai-message");
const starter = document.getElementById("squelette").textContent.replace(/^\n/, "");
let draftKey = `balise-brouillon:${form.dataset.account}:${form.dataset.exercise}`;
let editor = plainEditor();

// What any editor offers; this one is the text area itself.
function plainEditor() {
  area.addEventListener("input", saveDraft);
  area.addEventListener("keydown", (event) => {
    if (event.key === "Enter" && (event.ctrlKey || event.metaKey)) form.requestSubmit();
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
  const kept = keep(draftKey, editor.get());
  document.getElementById("brouillon").textContent = kept ? "Brouillon enregistré" : "";
}

async function setUpEditor() {
  const taken = form.dataset.taken === "true" ? area.value : null;
  const text = recall(draftKey) ?? area.value;
  area.value = text;
  try {
    const { createEditor } = await import("./editor.js");
    editor = createEditor({ area, text: area.value, onChange: saveDraft, onSubmit: () => form.requestSubmit() });
    document.documentElement.classList.add("has-editor");
  } catch (error) {
    console.warn("L’éditeur n’a pas pu être chargé ; la zone de texte reste.", error);
  }
  // Code taken up again from an attempt goes above the draft: Ctrl+Z gives the draft back.
  if (taken !== null && taken !== text) editor.set(taken);
  if (taken !== null) {
    saveDraft();
    history.replaceState(null, "", location.pathname);
  }
}

function showMessage(text) {
  message.textContent = text;
  message.hidden = !text;
}

async function submit(event) {
  event.preventDefault();
  if (form.getAttribute("aria-busy") === "true") return;
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
  showWaitingSoon();
  const body = new URLSearchParams({ code: area.value });
  const response = await fetch(form.action, { method: "POST", body, headers: { Accept: "application/json" } }).catch(
    () => null,
  );
  clearTimeout(waitingTimer);
  const answer = await readAnswer(response);
  if (response?.ok && answer) {
    moveDraft(answer.account);
    showWaiting(answer.text);
    return answer;
  }
  showMessage(answer?.detail ?? "Le serveur ne répond pas. Votre code est gardé ici : réessayez dans un instant.");
  return null;
}

// JSON when all went well; a refusal may also come as a page, whose sentence is what matters.
async function readAnswer(response) {
  if (!response) return null;
  if (response.headers.get("content-type")?.includes("json")) return response.json().catch(() => null);
  const parsed = new DOMParser().parseFromString(await response.text(), "text/html");
  return { detail: parsed.getElementById("detail")?.textContent };
}

let waitingTimer = 0;
function showWaitingSoon() {
  waitingTimer = setTimeout(() => announce("Envoi en cours"), 400);
}

// A visitor becomes a guest at the first submission: the draft follows.
function moveDraft(account) {
  if (String(account) === form.dataset.account) return;
  keep(draftKey, null);
  form.dataset.account = account;
  draftKey = `balise-brouillon:${account}:${form.dataset.exercise}`;
  saveDraft();
}

document.getElementById("recommencer").addEventListener("click", () => {
  if (!window.confirm("Revenir au code de départ ? Votre code actuel sera remplacé (Ctrl+Z le rend).")) return;
  editor.set(starter);
  saveDraft();
  editor.focus();
});

form.addEventListener("submit", submit);
for (const label of area.labels) label.addEventListener("click", () => editor.focus());
setUpEditor();
setUpSplitter(document.getElementById("cloison"));
