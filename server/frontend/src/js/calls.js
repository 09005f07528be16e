// A call of one's own, replayed line by line with what the editor holds.

export function setUpOwnCall(code) {
  const form = document.getElementById("rejouer-un-appel");
  if (!form) return;
  const { call, again } = form.elements;
  const wrong = document.getElementById("appel-refus");
  form.addEventListener("submit", async (event) => {
    event.preventDefault();
    const { asked, show } = await import("./steps/index.js");
    const trace = await asked(again, wrong, form.action, { code: code(), call: call.value });
    call.setAttribute("aria-invalid", String(!wrong.hidden));
    if (trace) show(trace);
    else call.focus();
  });
  call.addEventListener("input", () => {
    wrong.hidden = true;
    call.removeAttribute("aria-invalid");
  });
}
