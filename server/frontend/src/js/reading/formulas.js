// A formula in a sentence that is wider than the page gets a line of its own, and scrolls there.

const SETTLED = 200; // milliseconds after the last change of width

export function setUpFormulas(page) {
  const body = page.querySelector(".reading-body");
  const formulas = [...body.querySelectorAll(".katex")].filter((one) => !one.closest(".math-display, .table-scroll"));
  let width = 0;
  let timer = 0;

  function fit() {
    if (body.clientWidth === width) return;
    width = body.clientWidth;
    for (const one of formulas) release(one);
    const edge = body.getBoundingClientRect().right + 1;
    const wide = formulas.filter((one) => one.getBoundingClientRect().right > edge);
    for (const one of wide) {
      one.classList.add("katex-wide");
      one.tabIndex = 0;
    }
  }

  document.fonts.ready.then(fit);
  window.addEventListener("resize", () => {
    clearTimeout(timer);
    timer = setTimeout(fit, SETTLED);
  });
}

function release(formula) {
  if (!formula.classList.contains("katex-wide")) return;
  formula.classList.remove("katex-wide");
  formula.removeAttribute("tabindex");
}
