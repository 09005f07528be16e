// A word of the glossary shows its definition when it is pointed at, focused, or tapped once. Escape closes.

const OPENS_AFTER = 150; // milliseconds: the pointer that only passes opens nothing
const CLOSES_AFTER = 250; // time to reach the definition, and to read it under the pointer
const GAP = 8; // pixels

export function setUpTerms(page) {
  const definitions = document.getElementById("definitions");
  if (!definitions) return;
  const bubble = new Bubble();
  for (const term of page.querySelectorAll(".term[data-term]")) {
    const definition = definitions.querySelector(`[data-definition="${CSS.escape(term.dataset.term)}"]`);
    if (definition) bubble.serve(term, definition);
  }
}

class Bubble {
  constructor() {
    this.box = document.createElement("div");
    this.box.id = "definition";
    this.box.className = "definition";
    this.box.setAttribute("role", "tooltip");
    this.box.hidden = true;
    document.querySelector("main").append(this.box);
    this.term = null;
    this.timer = 0;
    this.box.addEventListener("pointerenter", () => clearTimeout(this.timer));
    this.box.addEventListener("pointerleave", () => this.closeSoon());
    document.addEventListener("keydown", (event) => {
      if (event.key === "Escape") this.close();
    });
    document.addEventListener("pointerdown", (event) => {
      if (!this.box.contains(event.target) && event.target.closest(".term") !== this.term) this.close();
    });
  }

  serve(term, definition) {
    term.addEventListener("pointerenter", (event) => {
      if (event.pointerType === "mouse") this.openSoon(term, definition);
    });
    term.addEventListener("pointerleave", (event) => {
      if (event.pointerType === "mouse") this.closeSoon();
    });
    term.addEventListener("focus", () => {
      if (term.matches(":focus-visible")) this.open(term, definition);
    });
    term.addEventListener("blur", () => this.close());
    term.addEventListener("click", (event) => {
      // The first tap of a finger shows the definition, the second follows the link.
      if (event.pointerType === "mouse" || event.detail === 0 || this.term === term) return;
      event.preventDefault();
      this.open(term, definition);
    });
  }

  openSoon(term, definition) {
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.open(term, definition), OPENS_AFTER);
  }

  closeSoon() {
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.close(), CLOSES_AFTER);
  }

  open(term, definition) {
    this.close();
    this.term = term;
    this.box.innerHTML = definition.innerHTML;
    this.box.hidden = false;
    term.setAttribute("aria-describedby", this.box.id);
    this.place(term.getClientRects()[0]);
  }

  // Below the word, or above it where there is no room.
  place(word) {
    const { width, height } = this.box.getBoundingClientRect();
    const room = document.documentElement.clientWidth - width - GAP;
    const below = word.bottom + GAP + height <= window.innerHeight || word.top < height + GAP;
    this.box.style.left = `${window.scrollX + Math.max(GAP, Math.min(word.left, room))}px`;
    this.box.style.top = `${window.scrollY + (below ? word.bottom + GAP : word.top - GAP - height)}px`;
  }

  close() {
    clearTimeout(this.timer);
    this.term?.removeAttribute("aria-describedby");
    this.term = null;
    this.box.hidden = true;
  }
}
