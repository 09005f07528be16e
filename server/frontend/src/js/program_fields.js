// The students' editor over the fields of a teacher's form that hold a program. The text area stays what the form sends:
// what is typed in the editor goes into it, and `refresh` brings back what was put into it. Without the editor it remains.

const KEYS = "Tab indente ; Échap puis Tab pour sortir de l’éditeur.";
const editors = new WeakMap(); // of each text area
let load = null;

// Give an editor to each program that is shown below `place`, and to those that are unfolded later.
export function setUpProgramFields(place) {
  for (const area of place.querySelectorAll("textarea[data-program]")) setUpField(area);
  place.addEventListener("toggle", ({ target }) => target.querySelectorAll("textarea[data-program]").forEach(setUpField), true);
}

export function refresh(place) {
  for (const area of place.querySelectorAll("textarea[data-program]")) {
    const editor = editors.get(area);
    if (editor && editor.get() !== area.value) editor.set(area.value);
  }
}

// A copy of a part of the form has the text areas alone.
export function removeEditors(place) {
  for (const area of place.querySelectorAll("textarea[data-program]")) {
    const section = area.closest(".editor");
    area.hidden = false;
    if (section) section.replaceWith(area);
  }
}

async function setUpField(area) {
  if (editors.has(area) || !area.checkVisibility()) return;
  editors.set(area, null);
  const had = document.activeElement === area ? area.selectionStart : null;
  try {
    load ??= import("./editor.js");
    const { createEditor, onTouchWidth } = await load;
    const section = document.createElement("div");
    section.className = "editor";
    area.before(section);
    const foot = document.createElement("div");
    foot.className = "editor-foot";
    foot.innerHTML = '<p class="keys small"></p>';
    foot.firstChild.textContent = KEYS;
    section.append(area, foot);
    let covered = () => 0;
    const editor = createEditor({
      area,
      text: area.value,
      label: `${area.labels[0].textContent}. ${KEYS}`,
      onChange: () => take(area, editors.get(area)),
      onSubmit: () => area.form.requestSubmit(area.form.querySelector("button.primary")),
      covered: () => covered(),
    });
    editors.set(area, editor);
    for (const label of area.labels) label.addEventListener("click", () => editor.focus());
    if (had !== null) editor.focus();
    onTouchWidth(async () => {
      const { setUpKeysBar } = await import("./keys_bar.js");
      covered = setUpKeysBar(section, editor);
    });
  } catch (error) {
    console.warn("L’éditeur n’a pas pu être chargé ; la zone de texte reste.", error);
  }
}

function take(area, editor) {
  if (area.value === editor.get()) return;
  area.value = editor.get();
  area.dispatchEvent(new Event("input", { bubbles: true }));
}
