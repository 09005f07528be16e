// A bar of the keys that a phone's keyboard hides. While one writes, it stands above that keyboard; otherwise under the
// code. What is typed goes to the caret, as the same key of a keyboard would.

const KEYS = [
  ["⇥", "Indenter", "indent"],
  ["⇤", "Désindenter", "dedent"],
  ["(", "Parenthèses"],
  ["[", "Crochets"],
  ["{", "Accolades"],
  ['"', "Guillemets"],
  ["'", "Apostrophes"],
  [":", "Deux-points"],
  ["←", "Caractère précédent", "left"],
  ["→", "Caractère suivant", "right"],
  ["↑", "Ligne du dessus", "up"],
  ["↓", "Ligne du dessous", "down"],
  ["=", "Égal"],
  ["_", "Tiret bas"],
  ["#", "Croisillon"],
  ["↶", "Annuler la dernière frappe", "undo"],
];

// Returns a function: the pixels that the bar hides of the editor's last lines.
export function setUpKeysBar(section, editor) {
  const bar = document.createElement("div");
  bar.className = "keys-bar no-print";
  bar.setAttribute("role", "group");
  bar.setAttribute("aria-label", "Touches pour le code");
  bar.append(...KEYS.map(([sign, label, command]) => key(sign, label, () => press(editor, sign, command))));
  const stand = document.createElement("div");
  stand.className = "keys-stand";
  stand.append(bar);
  section.querySelector(".editor-foot").before(stand);

  const seen = window.visualViewport;
  const host = section.querySelector(".editor-host");
  const place = () => {
    const writes = document.activeElement === host || bar.contains(document.activeElement);
    const above = writes && seen.scale < 1.1;
    if (above) stand.style.height = `${stand.offsetHeight}px`;
    bar.classList.toggle("keys-above", above);
    if (!above) stand.style.height = "";
    bar.style.bottom = above ? `${Math.max(0, document.documentElement.clientHeight - seen.height - seen.offsetTop)}px` : "";
  };
  section.addEventListener("focusin", place);
  section.addEventListener("focusout", () => setTimeout(place));
  seen.addEventListener("resize", place);
  seen.addEventListener("scroll", place);
  place();
  return () => (bar.classList.contains("keys-above") ? bar.offsetHeight : 0);
}

function press(editor, sign, command) {
  if (command) editor.command(command);
  else editor.type(sign);
  editor.focus();
}

function key(sign, label, action) {
  const made = document.createElement("button");
  made.type = "button";
  made.textContent = sign;
  made.setAttribute("aria-label", label);
  made.addEventListener("mousedown", (event) => event.preventDefault()); // the keyboard stays
  made.addEventListener("click", action);
  return made;
}
