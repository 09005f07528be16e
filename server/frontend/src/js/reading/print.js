// On paper nothing can be unfolded: everything is, while the page is printed.

export function setUpPrinting(page) {
  let opened = [];
  window.addEventListener("beforeprint", () => {
    opened = [...page.querySelectorAll(".reading-body details:not([open])")];
    for (const one of opened) one.open = true;
  });
  window.addEventListener("afterprint", () => {
    for (const one of opened) one.open = false;
  });
}
