// Buttons that copy what a field holds: `data-copy` names the field.

const BACK_AFTER = 2000; // milliseconds

export function setUpFieldCopies() {
  for (const button of document.querySelectorAll("button[data-copy]")) {
    const said = button.textContent;
    button.addEventListener("click", async () => {
      const done = await copied(document.getElementById(button.dataset.copy));
      button.textContent = done ? "Copié" : "Sélectionné : Ctrl+C le copie";
      document.getElementById("annonce").textContent = button.textContent;
      setTimeout(() => (button.textContent = said), BACK_AFTER);
    });
  }
}

// A page served without HTTPS has no clipboard: the text is then selected, ready to be copied.
async function copied(field) {
  field.select();
  try {
    await navigator.clipboard.writeText(field.value);
    return true;
  } catch {
    return document.execCommand("copy");
  }
}
