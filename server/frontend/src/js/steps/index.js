// « Rejouer pas à pas »: asks the server for a trace, and opens it over the page.

import { button, make } from "../replays/dom.js";
import { Player } from "./player.js";

const FAILED = "Le serveur ne répond pas. Réessayez dans un instant.";
const LONGEST_CALL = 4000; // characters, of one that may be typed
let styled = null;

/** {trace} or {refusal: a sentence}. */
export async function ask(address, body) {
  const response = await fetch(address, {
    method: "POST",
    headers: { "Content-Type": "application/json", Accept: "application/json" },
    body: JSON.stringify(body),
  }).catch(() => null);
  const answer = await response?.json().catch(() => null);
  if (response?.ok && answer) return { trace: answer };
  return { refusal: typeof answer?.detail === "string" ? answer.detail : FAILED };
}

/** Asks on behalf of a button, which says that it waits; a refusal is said in `place`. Returns the trace, or null. */
export async function asked(asking, place, address, body, wait = "Rejeu en cours…") {
  if (asking.getAttribute("aria-busy") === "true") return null;
  const words = asking.textContent;
  asking.setAttribute("aria-busy", "true");
  asking.textContent = wait;
  place.hidden = true;
  const [{ trace, refusal }] = await Promise.all([ask(address, body), styles()]);
  asking.removeAttribute("aria-busy");
  asking.textContent = words;
  place.textContent = refusal ?? "";
  place.hidden = !refusal;
  return trace ?? null;
}

/** A failed check's counterexample, for the button that stands under it. */
export async function replay(asking) {
  const check = asking.closest(".check-body");
  const place = asking.parentElement.querySelector(".problem") ?? asking.parentElement.appendChild(refused());
  const trace = await asked(asking, place, asking.dataset.steps, { check: asking.dataset.check });
  if (!trace || !asking.isConnected) return; // another verdict has taken its place
  if (trace.steps.length === 0 && trace.end.kind === "cut") {
    place.textContent = `${trace.end.title}. ${trace.end.message}`;
    place.hidden = false;
    return;
  }
  offer(trace.call);
  show(trace, [...check.querySelectorAll(".counterexample > .expected")]);
}

/** One changes a number of what was replayed, and looks again: it stands in the field of a call of one's own. */
function offer(call) {
  const field = document.getElementById("appel");
  if (!field || field.value !== field.defaultValue || call.length > LONGEST_CALL || /…|\[tableau/.test(call)) return;
  field.value = field.defaultValue = call;
}

/** Where a refusal is said. */
export function refused() {
  return make("p", { class: "problem", role: "alert", hidden: true });
}

/** Opens a trace over the page; `told` as in `Player`. */
export async function show(trace, told = []) {
  await styles();
  document.querySelector("dialog.stepping")?.close();
  const player = new Player(trace, told);
  const close = button("Fermer", () => dialog.close());
  const title = make("h2", { id: "titre-pas-a-pas" }, "Pas à pas");
  const call = make("code", { class: "steps-call" }, trace.call);
  const head = make("header", { class: "steps-head" }, title, call, close);
  const dialog = make("dialog", { class: "stepping", "aria-labelledby": "titre-pas-a-pas" }, head, player.element);
  dialog.addEventListener("close", () => dialog.remove());
  document.body.append(dialog);
  dialog.showModal();
  player.begin();
  (player.trace.length > 0 ? player.controls.buttons.on : close).focus();
  return dialog;
}

/** The styles come with the first trace: a page that shows none does without. */
function styles() {
  const page = document.querySelector("link[rel=stylesheet][href$='css/app.css']");
  styled ??= new Promise((done) => {
    const link = make("link", { rel: "stylesheet", href: page.href.replace(/app\.css$/, "steps.css"), onload: done, onerror: done });
    document.head.append(link);
  });
  return styled;
}
