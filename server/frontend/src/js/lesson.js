// The lesson of a class, and what is projected of it: changes come by server-sent events; keys act on them.

import { announce } from "./follow.js";

const AGAIN_MS = 30_000;
const page = document.querySelector("[data-stream]");
const state = page?.querySelector("[data-live]");
const dialog = document.querySelector("[data-dialog]");
let chosen = "";

function say(kind, text) {
  if (!state || state.dataset.kind === kind) return;
  if (state.dataset.kind) announce(text);
  state.dataset.kind = kind;
  state.textContent = text;
}

function connect() {
  const source = new EventSource(page.dataset.stream);
  source.onopen = () => say("live", "En direct");
  source.addEventListener("parts", ({ data }) => putParts(JSON.parse(data)));
  source.addEventListener("ended", () => {
    source.close();
    location.assign(page.dataset.close ?? location.href);
  });
  source.onerror = () => {
    say("broken", "Interrompu");
    if (source.readyState === EventSource.CLOSED) setTimeout(connect, AGAIN_MS);
  };
}

// What had the focus has it again, if it is still there.
function putParts(parts) {
  for (const [name, html] of Object.entries(parts)) {
    const place = page.querySelector(`[data-part="${name}"]`);
    if (!place) continue;
    const focused = place.contains(document.activeElement) ? keyOf(document.activeElement) : null;
    place.innerHTML = html;
    if (focused) find(place, focused)?.focus({ preventScroll: true });
  }
  choose(chosen);
}

function keyOf(element) {
  const row = element.closest("[data-key]");
  return row && [row.dataset.key, [...row.querySelectorAll("a, button")].indexOf(element)];
}

function find(place, [key, at]) {
  return place.querySelector(`[data-key="${CSS.escape(key)}"]`)?.querySelectorAll("a, button")[at];
}

function rows() {
  return [...(page?.querySelectorAll(".stuck-row") ?? [])];
}

function choose(key) {
  chosen = key;
  for (const row of rows()) row.toggleAttribute("data-chosen", row.dataset.key === key);
}

function step(by) {
  const all = rows();
  if (!all.length) return;
  const at = all.findIndex((row) => row.dataset.key === chosen);
  const row = all[Math.max(0, Math.min(all.length - 1, at < 0 ? (by > 0 ? 0 : all.length - 1) : at + by))];
  choose(row.dataset.key);
  row.querySelector(".stuck-name").focus({ preventScroll: true });
  row.scrollIntoView({ block: "nearest" });
}

function chosenRow() {
  return rows().find((row) => row.dataset.key === chosen) ?? rows()[0];
}

async function see(button) {
  const form = button.form;
  const row = button.closest(".stuck-row");
  const body = new FormData(form);
  body.set("eleve", button.value);
  const response = await post(form.action, body);
  if (!response) return form.requestSubmit(button);
  announce(`${row.dataset.name} : vu`);
  const fresh = new DOMParser().parseFromString(await response.text(), "text/html");
  const parts = [...fresh.querySelectorAll("[data-part]")].map((part) => [part.dataset.part, part.innerHTML]);
  putParts(Object.fromEntries(parts));
}

async function post(address, body) {
  try {
    const response = await fetch(address, { method: "POST", body });
    return response.ok ? response : null;
  } catch {
    return null;
  }
}

function openDialog(link) {
  const row = link.closest(".stuck-row");
  const form = dialog.querySelector("form");
  const action = link.getAttribute("href").split("#")[0];
  if (form.getAttribute("action") !== action) form.reset();
  form.action = action;
  dialog.querySelector("[data-to]").textContent = row.dataset.name;
  dialog.querySelector("[data-problem]").hidden = true;
  dialog.showModal();
}

async function sendMessage(event) {
  event.preventDefault();
  const form = event.target;
  const response = await post(form.action, new FormData(form));
  if (response) {
    form.reset();
    dialog.close();
    return announce("Message envoyé");
  }
  const problem = dialog.querySelector("[data-problem]");
  problem.textContent = "Le message n’est pas parti : il est gardé ici. Réessayez dans un instant.";
  problem.hidden = false;
}

const KEYS = {
  ArrowDown: () => step(1),
  ArrowUp: () => step(-1),
  j: () => step(1),
  k: () => step(-1),
  v: () => chosenRow()?.querySelector("[data-seen]")?.click(),
  e: () => chosenRow()?.querySelector("[data-write]")?.click(),
  p: () => page.querySelector(".lesson-tools a")?.click(),
  "?": () => document.querySelector("[data-keys]")?.showModal(),
};

// On a projected page.
const WALL_KEYS = {
  Escape: () => location.assign(wall.dataset.close),
  m: () => wall.toggleAttribute("data-unmarked"),
  e: () => wall.querySelector("details")?.toggleAttribute("open"),
  ArrowRight: () => turn(1),
  ArrowLeft: () => turn(-1),
};
const wall = document.querySelector("main.wall[data-close]");

function turn(by) {
  const others = [...wall.querySelectorAll("[data-other]")].map((link) => link.getAttribute("href"));
  const at = others.indexOf(location.pathname);
  const next = others[(at + by + others.length) % others.length];
  if (others.length > 1 || (others.length && at < 0)) location.assign(next);
}

function project(number) {
  page.querySelectorAll(".mistake-row")[number]?.querySelector("[data-project]")?.click();
}

document.addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.metaKey || event.altKey || event.isComposing) return;
  if (event.target.closest("input:not([type=radio]), textarea, select, dialog, pre")) return;
  const act = wall ? WALL_KEYS[event.key] : (KEYS[event.key] ?? (/^[1-3]$/.test(event.key) && (() => project(event.key - 1))));
  if (!act) return;
  event.preventDefault();
  act();
});

if (page && window.EventSource) connect();
if (page && !wall) {
  page.addEventListener("click", (event) => {
    const seen = event.target.closest("[data-seen]");
    const write = event.target.closest("[data-write]");
    if (seen) {
      event.preventDefault();
      see(seen);
    } else if (write && dialog && !event.ctrlKey && !event.metaKey) {
      event.preventDefault();
      openDialog(write);
    }
  });
  page.addEventListener("focusin", ({ target }) => {
    const row = target.closest(".stuck-row");
    if (row) choose(row.dataset.key);
  });
  dialog?.querySelector("form").addEventListener("submit", sendMessage);
  dialog?.querySelector("[data-close]").addEventListener("click", () => dialog.close());
}
