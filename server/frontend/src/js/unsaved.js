// What was typed in a form and has not reached the server, with the version of the form that it changes.

import { keep, recall } from "./storage.js";

// The draft under a key, or null: what an older page wrote there says no version.
export function readDraft(key) {
  const text = recall(key);
  if (text === null) return null;
  try {
    const { version, fields } = JSON.parse(text);
    return typeof fields === "string" ? { version, fields } : null;
  } catch {
    return { version: "", fields: text };
  }
}

export function writeDraft(key, draft) {
  keep(key, draft && JSON.stringify(draft));
}

// Puts fields into a form; `add` makes the form larger where it has none of this name.
export function fill(form, fields, add) {
  const typed = new URLSearchParams(fields);
  for (const box of form.querySelectorAll("[type=checkbox]:not([data-pick])")) box.checked = typed.has(box.name);
  for (const [name, value] of typed) {
    if (value && !form.elements[name]) add(name);
  }
  for (const field of form.elements) {
    if (!field.name || ["hidden", "checkbox", "submit"].includes(field.type)) continue;
    if (typed.has(field.name)) field.value = typed.get(field.name);
  }
}

// Where a draft changes an older version than the form shows, one chooses: `swap` shows the other of both and returns
// what was shown.
export function setUpAside(place, key, swap) {
  const aside = `${key}:autre`;
  const words = place.querySelector("[data-words]");
  const [show, forget] = place.querySelectorAll("button");
  let isDraft = false;

  function offer() {
    place.hidden = recall(aside) === null;
    words.textContent = isDraft
      ? "La saisie de ce navigateur est reprise. La version qui était enregistrée reste gardée ici :"
      : "Ce navigateur garde une saisie qui n’est pas enregistrée : l’exercice a été enregistré ailleurs entre-temps.";
    show.textContent = isDraft ? "Revenir à la version enregistrée" : "Reprendre cette saisie";
    forget.textContent = isDraft ? "Oublier l’autre version" : "Oublier cette saisie";
  }

  show.addEventListener("click", () => {
    writeDraft(aside, swap(readDraft(aside)));
    isDraft = !isDraft;
    offer();
  });
  forget.addEventListener("click", () => {
    keep(aside, null);
    place.hidden = true;
  });
  offer();
  return (draft) => {
    writeDraft(aside, draft);
    offer();
  };
}
