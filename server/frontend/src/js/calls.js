// A call of one's own, replayed line by line with what the editor holds. What stands in its field when nothing was typed
// there is the field's default: an example, or the last counterexample that was replayed.

import { asked, show } from "./steps/index.js";

export function setUp(form, code) {
  const { call, again } = form.elements;
  const wrong = document.getElementById("appel-refus");

  const right = () => {
    wrong.hidden = true;
    call.removeAttribute("aria-invalid");
  };
  form.addEventListener("submit", async (event) => {
    event.preventDefault();
    right();
    const trace = await asked(again, wrong, form.action, { code: code(), call: call.value });
    if (trace) return show(trace);
    if (wrong.hidden) return; // asked already
    call.setAttribute("aria-invalid", "true");
    call.focus();
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
  again.disabled = false;
}
