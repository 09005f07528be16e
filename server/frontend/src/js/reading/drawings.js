// A button to look at a drawing in a large window.

export function setUpDrawings(page) {
  const viewer = makeViewer();
  for (const drawing of page.querySelectorAll(".drawing")) {
    const button = document.createElement("button");
    button.type = "button";
    button.className = "enlarge";
    button.textContent = "Agrandir";
    button.setAttribute("aria-label", `Agrandir la ${named(drawing)}`);
    button.addEventListener("click", () => show(viewer, drawing));
    drawing.append(button);
  }
}

// « figure 3 »: a page has many of these buttons, and a list of them must tell one from another.
function named(drawing) {
  const number = drawing.querySelector(".figure-number")?.textContent.match(/\d+/);
  return number ? `figure ${number[0]}` : "figure";
}

function makeViewer() {
  const viewer = document.createElement("dialog");
  viewer.className = "viewer";
  viewer.setAttribute("aria-label", "Figure agrandie");
  viewer.innerHTML = '<form method="dialog"><button class="link-button">Fermer</button></form><div></div>';
  viewer.addEventListener("click", (event) => {
    if (event.target === viewer) viewer.close();
  });
  document.body.append(viewer);
  return viewer;
}

function show(viewer, drawing) {
  const copies = [...drawing.querySelectorAll("img")].map((image) => {
    const copy = image.cloneNode();
    copy.loading = "eager";
    return copy;
  });
  viewer.querySelector("div").replaceChildren(...copies);
  viewer.showModal();
}
