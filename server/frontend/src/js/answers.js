// The page of an exercise answered without code: draft, submission without leaving the page, steps to be ordered.

import { inherited } from "./drafts.js";
import { followToVerdict, showWaiting } from "./follow.js";
import { setUpOrder } from "./answers/order.js";
import { reconciled, savesOf } from "./saves.js";
import { adopt, post, STATE_FIELDS, wayOn, withState } from "./send.js";
import { setUpSplitter } from "./splitter.js";
import { draftOfPage } from "./versions.js";

const form = document.getElementById("essai");
const message = document.getElementById("essai-message");
const orders = [...form.querySelectorAll("[data-order]")].map((question) => setUpOrder(question, saveDraft));
const draft = draftOfPage(keyOf(form.dataset.account), {
  get: () => answered().toString(),
  set: fill,
  again: () => form.querySelector("input, select, button")?.focus(),
});

const saves = savesOf(form, keyOf(form.dataset.account), {
  text: () => answered().toString(),
  body: () => withState(form, answered()),
});

// A draft belongs to one draw: under other letters it would say something else.
function keyOf(account) {
  return `balise-brouillon:${account}:${form.dataset.exercise}:${form.dataset.seed}`;
}

function answered() {
  const fields = new URLSearchParams(new FormData(form));
  for (const name of STATE_FIELDS) fields.delete(name);
  return fields;
}

function saveDraft() {
  document.getElementById("brouillon").textContent = draft.save() ? "Brouillon enregistré" : "";
  saves.changed();
}

function fill(text) {
  const fields = new URLSearchParams(text);
  for (const field of form.elements) {
    if (!field.name || STATE_FIELDS.includes(field.name)) continue;
    if (field.type === "radio" || field.type === "checkbox") field.checked = fields.getAll(field.name).includes(field.value);
    else field.value = fields.get(field.name) ?? "";
  }
  for (const order of orders) order.show();
}

async function submit(event) {
  event.preventDefault();
  if (form.getAttribute("aria-busy") === "true") return;
  showMessage("");
  busy(true);
  try {
    const answer = await post(form.action, withState(form, answered()), form.dataset.account);
    if (answer.accepted) {
      moveDraft(answer.accepted.account);
      showWaiting(answer.accepted.text);
      await followToVerdict(answer.accepted);
    } else {
      const away = "Le serveur ne répond pas. Vos réponses sont gardées ici : réessayez dans un instant.";
      showMessage(answer.refusal ?? away, wayOn(form, answer.problem));
    }
  } finally {
    busy(false);
  }
}

function showMessage(text, step = null) {
  message.replaceChildren(text, ...(step ? [" ", step] : []));
  message.hidden = !text;
}

function busy(state) {
  form.setAttribute("aria-busy", String(state));
  document.getElementById("envoyer").setAttribute("aria-disabled", String(state));
}

// The session may have changed hands while the page was open: the draft follows.
function moveDraft(account) {
  adopt(form, { account });
  draft.move(keyOf(String(account)));
}

if (form.dataset.taken === "true") {
  saveDraft();
  history.replaceState(null, "", location.pathname);
} else {
  const before = inherited(form.dataset.account, keyOf);
  const there = answered().toString();
  const text = before ?? reconciled(form, keyOf(form.dataset.account), draft, there);
  if (text !== there) fill(text);
  if (before !== null) saveDraft();
  else if (text !== there) saves.changed();
}
for (const order of orders) order.show();
draft.tellAnother();
form.addEventListener("input", saveDraft);
form.addEventListener("submit", submit);
setUpSplitter(document.getElementById("cloison"));
