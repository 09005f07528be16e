// A call of one's own, run, or replayed line by line, with what the editor holds; without a call, the file is run. What
// stands in its field when nothing was typed there is the field's default: an example, or the last counterexample that
// was replayed. Where a whole program is asked for, the field holds its standard input instead; where a class is, a small
// program that uses it.

import { make } from "./replays/dom.js";
import { asked, show } from "./steps/index.js";
import { Values } from "./steps/values.js";

export function setUp(form, code) {
  const { call, again, run, stdin, after } = form.elements;
  const [field, several] = [stdin ?? after ?? call, !call];
  const output = document.getElementById("appel-sortie");
  const wrong = document.getElementById("appel-refus");

  const right = () => {
    wrong.hidden = true;
    field.removeAttribute("aria-invalid");
  };
  const refused = () => {
    if (wrong.hidden) return; // asked already
    field.setAttribute("aria-invalid", "true");
    field.focus();
  };
  const execute = async () => {
    right();
    const given = several ? { call: "", [field.name]: field.value } : { call: call.value };
    const trace = await asked(run, wrong, form.action, { code: code(), ...given, plain: true }, "Exécution…");
    if (trace) output.replaceChildren(...parts(trace, several && Boolean(stdin || after.value.trim())));
    else refused();
  };
  form.addEventListener("submit", async (event) => {
    event.preventDefault();
    if (several) return execute();
    right();
    const trace = await asked(again, wrong, form.action, { code: code(), call: call.value });
    if (trace) show(trace);
    else refused();
  });
  field.addEventListener("input", right);
  if (several) {
    run.disabled = false;
    return; // there, Enter ends a line
  }
  run.addEventListener("click", execute);
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
function parts({ stdout, left_out: notes, end, call }, isProgram) {
  const printed = stdout ? [title("Affiché"), make("pre", { class: "cell-stdout", tabIndex: 0 }, stdout)] : [];
  const cut = notes.map((note) => make("p", { class: "cell-note" }, note));
  return [...printed, ...cut, ...(end.kind === "returned" ? returned(end, call || isProgram, stdout) : [fault(end)])];
}

function returned({ value }, saysNothing, stdout) {
  if (value) return [title("Renvoyé"), make("div", { class: "value" }, new Values().show(value, { key: "renvoi" }))];
  if (stdout) return [];
  return [make("p", { class: "cell-note" }, saysNothing ? "Rien n’est affiché." : "Votre fichier s’exécute, et n’affiche rien.")];
}

function fault({ title: name, message, line }) {
  return make("div", { class: "cell-fault" }, make("strong", {}, `${name}${line ? ` (ligne ${line})` : ""}`), make("p", {}, message));
}

function title(text) {
  return make("h3", { class: "own-call-title" }, text);
}
