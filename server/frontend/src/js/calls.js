// A call of one's own, run, or replayed line by line, with what the editor holds; without a call, the file is run. What stands in its field when nothing was typed
// there is the field's default: an example, or the last counterexample that was replayed.

import { make } from "./replays/dom.js";
import { asked, show } from "./steps/index.js";
import { Values } from "./steps/values.js";

export function setUp(form, code) {
  const { call, again, run } = form.elements;
  const output = document.getElementById("appel-sortie");
  const wrong = document.getElementById("appel-refus");

  const right = () => {
    wrong.hidden = true;
    call.removeAttribute("aria-invalid");
  };
  const refused = () => {
    if (wrong.hidden) return; // asked already
    call.setAttribute("aria-invalid", "true");
    call.focus();
  };
  form.addEventListener("submit", async (event) => {
    event.preventDefault();
    right();
    const trace = await asked(again, wrong, form.action, { code: code(), call: call.value });
    if (trace) show(trace);
    else refused();
  });
  run.addEventListener("click", async () => {
    right();
    const body = { code: code(), call: call.value, plain: true };
    const trace = await asked(run, wrong, form.action, body, "Exécution…");
    if (trace) output.replaceChildren(...parts(trace));
    else refused();
  });
  call.addEventListener("input", right);
  call.addEventListener("keydown", (event) => {
    if (event.key !== "Enter" || event.shiftKey) return;
    event.preventDefault();
    form.requestSubmit();
  });
  form.addEventListener("click", ({ target }) => {
    if (!target.dataset.call) return;
    call.value = call.defaultValue = target.dataset.call;
    right();
    call.focus();
  });
  again.disabled = run.disabled = false;
}

// What was printed, then what the call returned or why it did not.
function parts({ stdout, left_out: notes, end, call }) {
  const printed = stdout ? [title("Affiché"), make("pre", { class: "cell-stdout", tabIndex: 0 }, stdout)] : [];
  const cut = notes.map((note) => make("p", { class: "cell-note" }, note));
  return [...printed, ...cut, ...(end.kind === "returned" ? returned(end, call, stdout) : [fault(end)])];
}

function returned({ value }, call, stdout) {
  if (value) return [title("Renvoyé"), make("div", { class: "value" }, new Values().show(value, { key: "renvoi" }))];
  if (stdout) return [];
  return [make("p", { class: "cell-note" }, call ? "Rien n’est affiché." : "Votre fichier s’exécute, et n’affiche rien.")];
}

function fault({ title: name, message, line }) {
  return make("div", { class: "cell-fault" }, make("strong", {}, `${name}${line ? ` (ligne ${line})` : ""}`), make("p", {}, message));
}

function title(text) {
  return make("h3", { class: "own-call-title" }, text);
}
