// Ctrl+Maj+Entrée goes to the verdict; once more, back to where one was.

import { announce, focusTitle } from "./follow.js";

export function setUpVerdictKey() {
  let before = null;
  document.addEventListener("keydown", (event) => {
    if (event.key !== "Enter" || !event.shiftKey || !(event.ctrlKey || event.metaKey)) return;
    const place = document.querySelector("[data-part=verdict]");
    if (!place) return;
    event.preventDefault();
    if (place.hidden) return announce("Pas encore de verdict : envoyez d’abord.");
    if (place.contains(document.activeElement)) return before?.focus();
    before = focused();
    focusTitle(place).scrollIntoView({ block: "nearest" });
  });
}

// The element that has the focus, in the editor's shadow tree too.
function focused() {
  let found = document.activeElement;
  while (found?.shadowRoot?.activeElement) found = found.shadowRoot.activeElement;
  return found;
}
