// On paper nothing can be unfolded: everything is, while the page is printed. Drawings load when one comes near them,
// so the button fetches them first, in the colours of paper.

const PATIENCE = 20000; // milliseconds: a drawing that nobody has looked at yet takes its time

export function setUpPrinting(page) {
  let opened = [];
  window.addEventListener("beforeprint", () => {
    opened = [...page.querySelectorAll(".reading-body details:not([open])")];
    for (const one of opened) one.open = true;
  });
  window.addEventListener("afterprint", () => {
    for (const one of opened) one.open = false;
  });

  const button = page.querySelector("[data-print]");
  button?.addEventListener("click", async () => {
    button.setAttribute("aria-disabled", "true");
    await Promise.race([drawingsOnPaper(page), new Promise((done) => setTimeout(done, PATIENCE))]);
    button.removeAttribute("aria-disabled");
    window.print();
  });
}

function drawingsOnPaper(page) {
  const images = [...page.querySelectorAll(".figure-light")];
  return Promise.all(images.map(loaded));
}

function loaded(image) {
  image.loading = "eager";
  if (image.complete) return Promise.resolve();
  return new Promise((done) => {
    image.addEventListener("load", done, { once: true });
    image.addEventListener("error", done, { once: true });
  });
}
