// A copy that is marked by hand: words that are picked and points that are typed exclude each other, the sum is shown, the
// draft is saved a moment after it changes, and kept in this browser while the server does not answer.

import { headersFor } from "./send.js";
import { keep, recall } from "./storage.js";

const CALM_MS = 800;
const AGAIN_MS = 5000;

const form = document.querySelector("[data-rubric]");
const address = form?.getAttribute("action"); // `form.action` is the buttons of that name
const number = new Intl.NumberFormat("fr-FR", { maximumFractionDigits: 2 });
const clock = new Intl.DateTimeFormat("fr-FR", { timeStyle: "short" });

function pointsOf(criterion) {
  const typed = criterion.querySelector("[name^='p-']").value.trim();
  const text = typed || (criterion.querySelector("[type=radio]:checked")?.value ?? "");
  return text === "" ? null : Number(text.replace(",", "."));
}

function showTotal() {
  const all = [...form.querySelectorAll(".criterion")].map(pointsOf);
  const given = all.filter((points) => points !== null && Number.isFinite(points));
  const place = form.querySelector("[data-total]");
  const sum = number.format(given.reduce((total, points) => total + points, 0));
  const left = all.length - given.length;
  place.textContent = `Total : ${sum} / ${place.dataset.outOf}${left ? ` · ${left} critère${left > 1 ? "s" : ""} sans points` : ""}`;
}

function setUpDrafts(key) {
  const place = form.querySelector("[data-saved]");
  let [timer, changed, sending, over] = [null, false, false, false];

  const written = () => {
    const fields = new FormData(form);
    fields.delete("version");
    return new URLSearchParams(fields).toString();
  };

  async function save({ leaving = false } = {}) {
    clearTimeout(timer);
    if (over || !changed || (sending && !leaving)) return;
    sending = true;
    const before = written();
    const fields = new FormData(form);
    fields.set("action", "brouillon");
    const options = { method: "POST", body: fields, headers: headersFor(form.elements.pour.value), keepalive: leaving };
    const response = await fetch(address, options).catch(() => null);
    const answer = await response?.json().catch(() => null);
    sending = false;
    if (response?.ok && answer) {
      changed = written() !== before;
      form.elements.version.value = answer.version;
      keep(key, null);
      place.textContent = `Brouillon enregistré à ${clock.format(new Date(answer.saved_at)).replace(":", "\u00a0h\u00a0")}.`;
    } else if (answer?.detail) {
      over = response.status === 409;
      place.textContent = answer.detail;
    } else {
      keep(key, before);
      place.textContent = "Le serveur ne répond pas. Votre saisie est gardée ici ; nouvel essai dans un instant.";
    }
    if (changed) timer = setTimeout(save, AGAIN_MS);
  }

  const kept = recall(key);
  if (kept !== null) {
    for (const [name, value] of new URLSearchParams(kept)) {
      for (const field of form.querySelectorAll(`[name="${CSS.escape(name)}"]`)) {
        if (field.type === "radio") field.checked = field.value === value;
        else if (field.type !== "hidden") field.value = value;
      }
    }
    changed = true;
    place.textContent = "Une saisie qui n’avait pas atteint le serveur est reprise ici.";
    timer = setTimeout(save, CALM_MS);
  }

  form.addEventListener("input", () => {
    changed = true;
    clearTimeout(timer);
    timer = setTimeout(save, CALM_MS);
  });
  // What does not arrive is there again when the copy is opened again.
  form.addEventListener("submit", ({ submitter }) => {
    over = true;
    clearTimeout(timer);
    keep(key, submitter?.value === "terminer" ? written() : null);
  });
  document.addEventListener("visibilitychange", () => document.hidden && save({ leaving: true }));
  window.addEventListener("pagehide", () => save({ leaving: true }));
}

if (form) {
  form.addEventListener("input", ({ target }) => {
    const criterion = target.closest(".criterion");
    if (target.type === "radio") criterion.querySelector("[name^='p-']").value = "";
    else if (target.name?.startsWith("p-") && target.value.trim()) {
      for (const radio of criterion.querySelectorAll("[type=radio]")) radio.checked = false;
    }
    showTotal();
  });
  const key = `balise-copie:${address}`;
  if ("drafts" in form.dataset) setUpDrafts(key);
  else keep(key, null);
  showTotal();
}
