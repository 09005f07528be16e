// While one sits a test: the server keeps what is written, a moment after it changes and on leaving the page.

import { adopt, headersFor } from "./send.js";
import { keep, recall } from "./storage.js";

const CALM_MS = 1500;
const AGAIN_MS = 5000;
const SAVED = ":enregistre";

// What the fields are to hold: the draft, or what the server has where that was written elsewhere (the draft goes aside).
export function reconciled(form, key, draft, there) {
  if (form.dataset.restored !== "true" || draft.kept === null || draft.kept === there) return draft.kept ?? there;
  if (recall(key + SAVED) === there) return draft.kept;
  draft.yieldTo(there);
  return there;
}

/** `text` gives what is written, `body` what is sent of it; `changed` is to be called when it changes. */
export function savesOf(form, key, { text, body }) {
  if (!form.dataset.save) return { changed() {} };
  const place = document.getElementById("enregistre");
  const clock = new Intl.DateTimeFormat("fr-FR", { timeStyle: "short" });
  let [timer, changed, sending, over] = [null, false, false, false];

  function soon(wait) {
    clearTimeout(timer);
    if (!over) timer = setTimeout(save, wait);
  }

  async function save({ leaving = false, asked = false } = {}) {
    clearTimeout(timer);
    const written = text();
    if (over || !(changed || asked)) return;
    if (sending && !leaving) return soon(CALM_MS / 3);
    const fields = body();
    if (sending) fields.delete("depuis"); // on leaving: the version of the save under way is not known yet
    sending = true;
    const options = { method: "POST", body: fields, headers: headersFor(form.dataset.account), keepalive: leaving };
    const response = await fetch(form.dataset.save, options).catch(() => null);
    const answer = await response?.json().catch(() => null);
    sending = false;
    if (response?.ok && answer) {
      changed = text() !== written;
      adopt(form, { depuis: answer.depuis });
      keep(key + SAVED, written);
      place.textContent = `enregistré à ${clock.format(new Date(answer.saved_at)).replace(":", "\u00a0h\u00a0")}`;
      if (changed) soon(CALM_MS);
      return;
    }
    if (answer?.type?.endsWith(":autre-version")) return choose(answer);
    over = response?.status === 409;
    place.textContent = answer?.detail ?? "pas encore enregistré : le serveur ne répond pas, nouvel essai dans un instant";
    soon(AGAIN_MS);
  }

  // Another tab or machine has saved something else since: nothing is saved before the student has chosen.
  function choose(answer) {
    over = true;
    const mine = choice("Garder la mienne", () => {
      over = false;
      adopt(form, answer);
      save({ asked: true });
    });
    const theirs = choice("Prendre l’autre", () => {
      keep(key, null);
      keep(key + SAVED, null);
      location.reload();
    });
    place.replaceChildren(answer.detail, " ", mine, " ", theirs);
  }

  document.getElementById("enregistrer").addEventListener("click", (event) => {
    event.preventDefault();
    save({ asked: true });
  });
  document.addEventListener("visibilitychange", () => document.hidden && save({ leaving: true }));
  window.addEventListener("pagehide", () => save({ leaving: true }));
  document.addEventListener("balise:test-ending", () => save());
  document.addEventListener("balise:test-over", () => {
    over = true;
    clearTimeout(timer);
  });
  return {
    changed() {
      changed = true;
      soon(CALM_MS);
    },
  };
}

function choice(label, choose) {
  const button = document.createElement("button");
  button.type = "button";
  button.className = "button";
  button.textContent = label;
  button.addEventListener("click", choose);
  return button;
}
