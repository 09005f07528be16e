// The theme, its button, and the pictures that come in two.

import { keep } from "./storage.js";

const root = document.documentElement;
const prefersDark = window.matchMedia("(prefers-color-scheme: dark)");

export function setUpTheme() {
  document.getElementById("theme")?.addEventListener("click", () => choose(isDark() ? "light" : "dark"));
  prefersDark.addEventListener("change", showTheme);
}

export function showTheme() {
  const dark = isDark();
  const button = document.getElementById("theme");
  if (button) {
    button.setAttribute("aria-label", dark ? "Passer au thème clair" : "Passer au thème sombre");
    button.title = button.getAttribute("aria-label");
  }
  // Figures come in two themes: a <picture> follows the system, and the switch when it was used.
  for (const source of document.querySelectorAll("picture source[data-theme=dark]")) {
    source.media = root.dataset.theme ? (dark ? "screen" : "not all") : "screen and (prefers-color-scheme: dark)";
  }
}

function isDark() {
  const chosen = document.body.dataset.theme ?? root.dataset.theme;
  return chosen ? chosen === "dark" : prefersDark.matches;
}

// A theme of the root's own dresses each of a lesson's thousands of elements again. What is in sight takes it from the
// body first, while the blocks that are farther than a window away keep the one that they had; the root follows once
// that is painted.
function choose(theme) {
  keep("balise-theme", theme);
  const far = [...document.querySelectorAll(".reading-body > *")].filter(isFar);
  for (const block of far) block.dataset.kept = root.dataset.theme ?? "";
  document.body.dataset.theme = theme;
  if (far.length) requestAnimationFrame(() => setTimeout(settle));
  else settle();
}

function isFar(block) {
  const { top, bottom } = block.getBoundingClientRect();
  return bottom < -window.innerHeight || top > 2 * window.innerHeight;
}

function settle() {
  root.dataset.theme = document.body.dataset.theme ?? root.dataset.theme;
  delete document.body.dataset.theme;
  for (const block of document.querySelectorAll("[data-kept]")) delete block.dataset.kept;
  showTheme();
}
