// A call of one's own, replayed line by line with what the editor holds.

export function setUpOwnCall(code) {
  const form = document.getElementById("rejouer-un-appel");
  if (!form) return;
  const { call, again } = form.elements;
  const wrong = document.getElementById("appel-refus");
  let offered = call.value; // what stands there is ours until it is changed

  const right = () => {
    wrong.hidden = true;
    call.removeAttribute("aria-invalid");
  };
  const offer = (text) => {
    call.value = offered = text;
    right();
  };
  form.addEventListener("submit", async (event) => {
    event.preventDefault();
    const { asked, show } = await import("./steps/index.js");
    const trace = await asked(again, wrong, form.action, { code: code(), call: call.value });
    if (trace) return show(trace);
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
    offer(target.dataset.call);
    call.focus();
  });
  // A counterexample that was replayed is a call to begin from: one changes a number, and looks again.
  document.addEventListener("balise:replayed", ({ detail }) => {
    if (detail && call.value === offered) offer(detail);
  });
}
