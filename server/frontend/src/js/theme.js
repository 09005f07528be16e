// Loaded before the first paint, so that a chosen theme never flashes the other one.
{
  document.documentElement.classList.add("js");
  try {
    const chosen = localStorage.getItem("balise-theme");
    if (chosen === "light" || chosen === "dark") document.documentElement.dataset.theme = chosen;
  } catch {
    // Storage is refused in some private windows: the system's theme applies.
  }
}
