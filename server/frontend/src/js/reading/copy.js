// A button to copy each block of code.

const BACK_AFTER = 2000; // milliseconds

export function setUpCopying(page) {
  for (const block of page.querySelectorAll(".code-block")) {
    const button = document.createElement("button");
    button.type = "button";
    button.className = "copy";
    button.textContent = "Copier";
    button.setAttribute("aria-label", "Copier ce code");
    button.addEventListener("click", async () => {
      const done = await copy(block.querySelector("pre"));
      button.textContent = done ? "Copié" : "Code sélectionné";
      document.getElementById("annonce").textContent = done ? "Code copié." : "Code sélectionné : Ctrl+C le copie.";
      setTimeout(() => (button.textContent = "Copier"), BACK_AFTER);
    });
    block.append(button);
  }
}

// A page served without HTTPS has no clipboard: the code is then selected, ready to be copied.
async function copy(pre) {
  try {
    await navigator.clipboard.writeText(pre.textContent.replace(/\n$/, ""));
    return true;
  } catch {
    getSelection().selectAllChildren(pre);
    return document.execCommand("copy");
  }
}
