// The form of a teacher's exercise: saved a moment after it changes, its statement drawn as it is typed, and the panel of
// its trial brought up to date. What does not reach the server is kept in this browser.

import { refresh, removeEditors, setUpProgramFields } from "./program_fields.js";
import { headersFor } from "./send.js";
import { keep, recall } from "./storage.js";
import { fill, readDraft, setUpAside, writeDraft } from "./unsaved.js";

const CALM_MS = 1200;
const PREVIEW_MS = 350;
const AGAIN_MS = 5000;
const LOOK_MS = 700;
const ELSEWHERE =
  "Cet exercice a été enregistré ailleurs depuis (autre onglet, autre appareil). Ce que vous tapez ici n’est plus " +
  "enregistré, mais gardé dans ce navigateur : « Enregistrer et essayer » montre les deux versions.";
// Proposals that are ticked: they change nothing before their button is pressed.
const PICKED = ["cas", "erreur"];

const form = document.querySelector("[data-studio]");
const clock = new Intl.DateTimeFormat("fr-FR", { timeStyle: "short" });

function setUp() {
  const address = form.getAttribute("action"); // `form.action` is the buttons of that name
  const key = `balise-exercice:${address}`;
  const told = form.querySelector("[data-saved]");
  const panel = document.querySelector("[data-report]");
  const { number } = panel.querySelector("[data-number]").dataset;
  let [timer, look, changed, sending, over, elsewhere] = [null, null, false, false, false, false];

  const written = () => {
    const fields = new FormData(form);
    for (const name of ["version", ...PICKED]) fields.delete(name);
    return new URLSearchParams(fields).toString();
  };
  const draft = () => ({ version: form.elements.version.value, fields: written() });
  let held = null; // what this page holds under the key, where another tab may hold something too

  function hold(what) {
    held = what && JSON.stringify(what);
    writeDraft(key, what);
  }

  function show(html) {
    const typing = panel.contains(document.activeElement) && document.activeElement.matches("input:not([data-pick])");
    if (!typing) {
      const chosen = new Map([...panel.querySelectorAll("[data-pick]")].map(({ name, value, checked }) => [`${name} ${value}`, checked]));
      panel.innerHTML = html;
      for (const box of panel.querySelectorAll("[data-pick]")) box.checked = chosen.get(`${box.name} ${box.value}`) ?? box.checked;
    }
    const place = new DOMParser().parseFromString(html, "text/html").querySelector("[data-version]");
    clearTimeout(look);
    if (place && place.dataset.number !== number && !changed && !sending) location.reload(); // published: it may be shared
    if (place && "trying" in place.dataset) look = setTimeout(lookAgain, LOOK_MS);
    return place?.dataset.version;
  }

  async function lookAgain() {
    const response = await fetch(form.dataset.trial, { headers: headersFor(form.elements.pour.value) }).catch(() => null);
    if (response?.ok) show(await response.text());
    else look = setTimeout(lookAgain, AGAIN_MS);
  }

  async function save({ leaving = false } = {}) {
    clearTimeout(timer);
    if (elsewhere && changed) hold(draft());
    if (over || !changed || (sending && !leaving)) return;
    sending = true;
    const before = written();
    const sent = draft();
    const fields = new FormData(form);
    fields.set("action", "brouillon");
    const options = { method: "POST", body: fields, headers: headersFor(form.elements.pour.value), keepalive: leaving };
    const response = await fetch(address, options).catch(() => null);
    const isPanel = response?.ok && response.headers.get("content-type")?.startsWith("text/html");
    sending = false;
    if (isPanel) {
      changed = written() !== before;
      form.elements.version.value = show(await response.text()) ?? form.elements.version.value;
      if (recall(key) === held) hold(null);
      told.textContent = `Enregistré à ${clock.format(new Date()).replace(":", "\u00a0h\u00a0")}.`;
    } else {
      const answer = await response?.json().catch(() => null);
      over = elsewhere = response?.status === 409;
      hold(sent);
      told.textContent = (elsewhere ? ELSEWHERE : answer?.detail) ?? "Le serveur ne répond pas. Votre saisie est gardée ici ; nouvel essai dans un instant.";
    }
    if (changed) timer = setTimeout(save, isPanel ? CALM_MS : AGAIN_MS);
  }

  function take(fields) {
    fill(form, fields, addField);
    refresh(form);
    form.querySelectorAll(".studio-mistake:not([data-blank])").forEach(nameMistake);
    changed = true;
    timer = setTimeout(save, CALM_MS);
  }

  const setAside = setUpAside(form.querySelector("[data-aside]"), key, ({ fields }) => {
    const shown = draft();
    take(fields);
    return shown;
  });
  const before = readDraft(key);
  if (before !== null && before.fields !== written()) {
    if (before.version === form.elements.version.value) {
      held = recall(key);
      take(before.fields);
      told.textContent = "Une saisie qui n’avait pas atteint le serveur est reprise ici.";
    } else {
      setAside(before);
      keep(key, null);
    }
  }

  document.addEventListener("input", ({ target }) => {
    if (target.form !== form || target.matches("[data-pick]")) return;
    if (target.dataset.mirror) form.elements[target.dataset.mirror].value = target.value;
    changed = true;
    clearTimeout(timer);
    timer = setTimeout(save, CALM_MS);
  });
  form.addEventListener("submit", () => {
    over = true;
    clearTimeout(timer);
    if (!elsewhere && recall(key) === held) hold(null); // else both versions are shown, and this page may be left
  });
  document.addEventListener("visibilitychange", () => document.hidden && save({ leaving: true }));
  if (panel.querySelector("[data-trying]")) look = setTimeout(lookAgain, LOOK_MS);
}

function setUpPreview() {
  const source = form.querySelector("[data-preview]");
  const place = form.querySelector("[data-preview-place]");
  let timer = null;
  let number = 0;

  async function draw() {
    number += 1;
    const mine = number;
    const fields = new URLSearchParams({ enonce: source.value, module: source.dataset.module, pour: form.elements.pour.value });
    const options = { method: "POST", body: fields, headers: headersFor(form.elements.pour.value) };
    const response = await fetch(source.dataset.preview, options).catch(() => null);
    if (response?.ok && mine === number) place.innerHTML = await response.text();
  }

  source.addEventListener("input", () => {
    place.closest("details").open = true;
    clearTimeout(timer);
    timer = setTimeout(draw, PREVIEW_MS);
  });
}

// Cases are as high as what is typed in them, and so are programs where their editor is not there.
function grow(area) {
  area.style.height = "auto";
  area.style.height = `${area.scrollHeight + 2}px`;
}

// A new line of a program begins below the line before it, four spaces further after a colon.
function indentLine(event) {
  const { target: area, key, isComposing, shiftKey, ctrlKey, altKey, metaKey } = event;
  const isProgram = area.matches?.("textarea.code-area") && !area.closest(".case-table");
  if (key !== "Enter" || !isProgram || isComposing || shiftKey || ctrlKey || altKey || metaKey) return;
  const line = area.value.slice(0, area.selectionStart).split("\n").at(-1);
  const indent = line.match(/^ */)[0] + (/:\s*$/.test(line) ? "    " : "");
  if (indent && document.execCommand("insertText", false, `\n${indent}`)) event.preventDefault(); // it can be undone
}

// A row is always free below the examples.
function addRow(last) {
  const row = last.cloneNode(true);
  for (const area of row.querySelectorAll("textarea")) {
    area.name = area.name.replace(/-c-(\d+)-/, (_, number) => `-c-${Number(number) + 1}-`);
    area.setAttribute("aria-label", area.getAttribute("aria-label").replace(/\d+$/, (number) => Number(number) + 1));
    area.value = "";
  }
  last.after(row);
}

// A blank mistake is always free below the others; the one that is typed bears its title.
function addMistake(last) {
  const blank = document.createElement("template");
  blank.innerHTML = last.outerHTML.replace(/\be-(\d+)-/g, (_, number) => `e-${Number(number) + 1}-`);
  removeEditors(blank.content);
  last.removeAttribute("data-blank");
  last.after(blank.content);
  last.nextElementSibling.open = false;
  for (const field of last.nextElementSibling.querySelectorAll("input, textarea")) field.value = "";
  nameMistake(last);
}

function nameMistake(mistake) {
  mistake.querySelector("summary").textContent = mistake.querySelector("input").value.trim() || "Sans titre";
}

// A row of examples, or a mistake, for a field that the form has not yet.
function addField(name) {
  const [, part] = name.match(/^(v-\d+-c-)\d+-/) ?? [];
  const rows = part ? form.querySelectorAll(`.case-table tbody tr:has([name^="${part}"])`) : [];
  if (rows.length) addRow(rows[rows.length - 1]);
  else if (name.startsWith("e-")) addMistake(form.querySelector("[data-blank]"));
}

// What is open stays so when the page comes back from the server.
const OPEN = "balise-exercice-ouvert";
const firstField = (part) => part.querySelector("[name]")?.name ?? "";

function keepOpen() {
  form.addEventListener("submit", () => {
    const names = [...form.querySelectorAll("details[open]")].map(firstField);
    keep(OPEN, JSON.stringify({ at: location.pathname, names }));
  });
  const { at, names } = JSON.parse(recall(OPEN) ?? "{}");
  keep(OPEN, null);
  if (at !== location.pathname) return;
  for (const part of form.querySelectorAll("details:not([data-blank])")) part.open ||= names.includes(firstField(part));
}

if (form) {
  setUp();
  setUpPreview();
  keepOpen();
  for (const area of form.querySelectorAll("textarea.code-area")) grow(area);
  form.addEventListener("input", ({ target }) => {
    if (target.matches("textarea.code-area")) grow(target);
    const row = target.closest(".case-table tbody tr:last-child");
    if (row && target.value) addRow(row);
    const blank = target.closest("[data-blank]");
    if (blank && target.value) addMistake(blank);
    else if (target.matches(".studio-mistake input[name$='-titre']")) nameMistake(target.closest(".studio-mistake"));
  });
  form.addEventListener("keydown", indentLine);
  form.addEventListener("toggle", ({ target }) => target.querySelectorAll?.("textarea.code-area").forEach(grow), true);
}

setUpProgramFields(document.querySelector(".studio"));

// A program that is being graded: the page comes back with its verdict.
if (document.querySelector("[data-again]")) setTimeout(() => location.reload(), LOOK_MS);
