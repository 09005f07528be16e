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

// Settled, whatever came: a drawing that cannot be had must not keep the others from being printed.
function drawingsOnPaper(page) {
  return Promise.allSettled([...page.querySelectorAll(".figure-light")].map(fetched));
}

// An image that waits to be near the screen says that it is complete: a copy is fetched, which waits for nothing.
async function fetched(image) {
  const copy = new Image();
  copy.src = image.src;
  await copy.decode();
  image.loading = "eager";
  image.src = copy.src;
  await image.decode();
}
