// On paper nothing can be unfolded: everything is, while the page is printed.

export function setUpPrinting(page) {
  let opened = [];
  window.addEventListener("beforeprint", () => {
    opened = [...page.querySelectorAll(".reading-body details:not([open])")];
    for (const one of opened) one.open = true;
    for (const image of page.querySelectorAll("img[loading=lazy]")) image.loading = "eager";
  });
  window.addEventListener("afterprint", () => {
    for (const one of opened) one.open = false;
  });
}
