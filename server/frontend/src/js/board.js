// The board of a class: what changes comes by server-sent events, and is put in place without moving the reader.

import { announce } from "./follow.js";

const AGAIN_MS = 3000;
const page = document.querySelector("[data-stream]");
const state = page?.querySelector("[data-live]");
let version = page?.dataset.version;
let reloading = false;
let again = false;

function say(kind, text) {
  if (state.dataset.kind === kind) return;
  if (state.dataset.kind) announce(text);
  state.dataset.kind = kind;
  state.textContent = text;
}

function connect() {
  const address = new URL(page.dataset.stream, location.href);
  address.searchParams.set("version", version);
  const source = new EventSource(address);
  source.addEventListener("version", ({ data }) => {
    say("live", "En direct");
    if (!reloading) version = data;
  });
  source.addEventListener("cell", ({ data }) => putCell(JSON.parse(data)));
  source.addEventListener("counts", ({ data }) => {
    page.querySelector("[data-part=counts]").innerHTML = data;
  });
  source.addEventListener("misconceptions", ({ data }) => putMistakes(data));
  source.addEventListener("outdated", reload);
  source.onerror = () => {
    say("broken", "Interrompu");
    if (source.readyState === EventSource.CLOSED) setTimeout(connect, 10 * AGAIN_MS);
  };
}

function parsed(html) {
  const template = document.createElement("template");
  template.innerHTML = html;
  return template.content;
}

function putCell({ key, html }) {
  const old = page.querySelector(`td[data-key="${CSS.escape(key)}"]`);
  if (!old) return; // on another page of students
  const fresh = parsed(html).querySelector("td");
  replaceCell(old, fresh);
  flash(fresh);
  recount(fresh.closest("tr"));
}

function replaceCell(old, fresh) {
  const focused = old.contains(document.activeElement);
  old.replaceWith(fresh);
  if (focused) fresh.querySelector("a")?.focus({ preventScroll: true });
}

function recount(row) {
  const place = row?.querySelector("[data-solved]");
  if (place) place.textContent = row.querySelectorAll(".spot-solved").length;
}

function flash(cell) {
  cell.classList.add("fresh");
  setTimeout(() => cell.classList.remove("fresh"), 2000);
}

function putMistakes(html) {
  putRows(page.querySelector("[data-part=misconceptions]"), parsed(html));
}

// Each row keeps its element, so that what is focused or selected stays; rows take the order of the new ones.
function putRows(place, fresh) {
  const focused = place.contains(document.activeElement) ? document.activeElement : null;
  const known = new Map([...place.rows].map((row) => [row.dataset.key, row]));
  const wanted = [...fresh.querySelectorAll("tr[data-key]")].map((row) => {
    const old = known.get(row.dataset.key);
    if (!old) return document.adoptNode(row);
    putCells(old, row);
    return old;
  });
  if (wanted.some((row, at) => place.rows[at] !== row) || place.rows.length !== wanted.length) {
    place.replaceChildren(...wanted);
    if (focused?.isConnected) focused.focus({ preventScroll: true });
  }
}

function putCells(old, fresh) {
  [...fresh.cells].forEach((cell, at) => {
    if (!old.cells[at]) old.append(document.adoptNode(cell.cloneNode(true)));
    else if (old.cells[at].outerHTML !== cell.outerHTML) replaceCell(old.cells[at], cell.cloneNode(true));
  });
}

// What the page shows is not what the changes begin from: it is read anew, and put in place part by part.
async function reload() {
  again = reloading;
  if (reloading) return;
  reloading = true;
  try {
    const response = await fetch(location.href, { headers: { Accept: "text/html" } });
    if (!response.ok) return say("broken", "Interrompu");
    const fresh = new DOMParser().parseFromString(await response.text(), "text/html").querySelector("[data-stream]");
    if (!fresh) return say("broken", "Interrompu");
    version = fresh.dataset.version;
    for (const part of fresh.querySelectorAll("[data-part]")) {
      const old = page.querySelector(`[data-part="${part.dataset.part}"]`);
      if (!old || old.tagName !== part.tagName || headsDiffer(old, part)) return location.reload();
      if (part.tagName === "TBODY") putRows(old, part);
      else old.innerHTML = part.innerHTML;
    }
  } catch {
    say("broken", "Interrompu"); // the server cannot be reached: the stream says when it is back
  } finally {
    setTimeout(() => {
      reloading = false;
      if (again) reload();
    }, AGAIN_MS);
  }
}

// Columns that came or went: rows alone cannot be put in place.
function headsDiffer(old, part) {
  const heads = (body) => body.closest("table")?.tHead?.rows[0]?.cells.length;
  return heads(old) !== heads(part);
}

if (page && state && window.EventSource) connect();
