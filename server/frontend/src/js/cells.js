// Runnable cells of a page: the code is read as it stands, run on the server, and edited where it is. The editor is
// loaded when a reader first asks for it: a page may have many cells.

import { keep, recall } from "./storage.js";

const STOPPED = "La cellule est arrêtée.";
const FAILED = "Le serveur ne répond pas. Réessayez dans un instant.";
// Figures come with one and a half times the points that they take on the page.
const DENSITY = 1.5;
const seconds = new Intl.NumberFormat("fr-FR", { maximumSignificantDigits: 2 });

export function enhance(root = document) {
  for (const section of root.querySelectorAll("section.cell:not([data-ready])")) new Cell(section);
}

class Cell {
  constructor(section) {
    this.section = section;
    this.name = section.dataset.name;
    this.number = [...document.querySelectorAll("section.cell")].indexOf(section) + 1;
    this.key = `balise-cellule:${location.pathname}#${this.name}`;
    this.pre = section.querySelector(".cell-code pre");
    this.code = this.pre.querySelector("code") ?? this.pre;
    this.highlighted = [...this.code.childNodes];
    this.original = this.code.textContent.replace(/\n$/, "");
    this.text = this.original;
    this.editor = null;
    this.build();
    const draft = recall(this.key);
    if (draft !== null && draft !== this.original) this.show(draft);
    section.dataset.ready = "";
  }

  build() {
    this.section.setAttribute("role", "group");
    this.section.setAttribute("aria-label", `Cellule de code ${this.number}`);
    this.run = button("Exécuter", () => this.execute(), "primary");
    this.run.title = "Ctrl+Entrée";
    this.run.setAttribute("aria-keyshortcuts", "Control+Enter");
    this.stop = button("Arrêter", () => this.running?.abort());
    this.stop.hidden = true;
    this.modify = button("Modifier", () => this.edit({}));
    this.run.setAttribute("aria-label", `Exécuter la cellule ${this.number}`);
    this.modify.setAttribute("aria-label", `Modifier la cellule ${this.number}`);
    this.follow = button("Pas à pas", () => this.replay());
    this.follow.setAttribute("aria-label", `Rejouer pas à pas la cellule ${this.number}`);
    this.reset = button("Rétablir", () => this.restore());
    this.reset.title = "Revenir au code de départ";
    this.reset.hidden = true;
    this.time = element("span", "cell-time");
    const bar = element("div", "cell-bar");
    bar.append(this.run, this.stop, this.follow, this.modify, this.reset, this.time);
    this.output = element("div", "cell-output");
    this.output.setAttribute("role", "log");
    this.output.setAttribute("aria-live", "polite");
    this.output.setAttribute("aria-label", `Sortie de la cellule ${this.number}`);
    this.section.append(bar, this.output);
    this.pre.addEventListener("click", ({ clientX: x, clientY: y }) => {
      if (getSelection().isCollapsed) this.edit({ x, y });
    });
    this.pre.addEventListener("keydown", (event) => this.typed(event));
    this.section.addEventListener("keydown", (event) => {
      if (event.defaultPrevented || event.key !== "Enter" || !(event.ctrlKey || event.metaKey)) return;
      event.preventDefault();
      this.execute();
    });
  }

  get busy() {
    return this.section.getAttribute("aria-busy") === "true";
  }

  set busy(state) {
    this.section.setAttribute("aria-busy", String(state));
    this.run.setAttribute("aria-disabled", String(state));
    this.run.textContent = state ? "En cours" : "Exécuter";
    this.run.setAttribute("aria-label", `${state ? "En cours," : "Exécuter la"} cellule ${this.number}`);
    this.stop.hidden = !state;
  }

  show(text) {
    this.text = text;
    const changed = text !== this.original;
    if (this.editor) this.editor.set(text);
    else if (changed) this.code.textContent = text;
    else this.code.replaceChildren(...this.highlighted);
    this.reset.hidden = !changed;
  }

  changed() {
    this.text = this.editor.get();
    const same = this.text === this.original;
    keep(this.key, same ? null : this.text);
    this.reset.hidden = same;
  }

  restore() {
    keep(this.key, null);
    this.show(this.original);
    (this.editor ?? this.run).focus();
  }

  /** Opens the editor; with `at`, writing goes on in it: there, where it is a place on the screen. */
  async edit(at = null) {
    this.loading ??= this.load();
    await this.loading;
    if (at) this.editor.focus(at);
  }

  /** Whoever types on the code as it is read writes in it: what is typed while the editor is loaded comes with it. */
  async typed(event) {
    const written = event.key === "Enter" ? "\n" : event.key;
    if (event.ctrlKey || event.metaKey || event.altKey || written.length !== 1) return;
    event.preventDefault();
    this.waiting = (this.waiting ?? "") + written;
    await this.edit({});
    this.editor.insert(this.waiting);
    this.waiting = "";
  }

  async load() {
    const label = `Code de la cellule ${this.name}. Tab indente ; Échap puis Tab pour sortir de l’éditeur.`;
    const options = { area: this.pre, text: this.text, label, onChange: () => this.changed(), onSubmit: () => this.execute() };
    try {
      const { createEditor } = await import("./editor.js");
      this.editor = createEditor(options);
    } catch (error) {
      console.warn("L’éditeur n’a pas pu être chargé ; une zone de texte le remplace.", error);
      this.editor = plainEditor(options);
    }
    this.modify.hidden = true;
  }

  async execute() {
    if (this.busy) return;
    this.running = new AbortController();
    this.busy = true;
    this.time.textContent = "";
    try {
      this.present(await this.send(this.running.signal));
    } finally {
      if (document.activeElement === this.stop) this.run.focus();
      this.busy = false;
    }
  }

  /** Line by line, over the page. */
  async replay() {
    const { asked, refused, show } = await import("./steps/index.js");
    if (!this.refusal) this.section.append((this.refusal = refused()));
    const trace = await asked(this.follow, this.refusal, `${this.section.dataset.action}/pas`, { code: this.text });
    if (trace) show(trace);
  }

  async send(signal) {
    const response = await fetch(this.section.dataset.action, {
      method: "POST",
      headers: { "Content-Type": "application/json", Accept: "application/json" },
      body: JSON.stringify({ code: this.text }),
      signal,
    }).catch(() => null);
    if (signal.aborted) return { refusal: STOPPED };
    const answer = await response?.json().catch(() => null);
    if (response?.ok && answer) return answer;
    return { refusal: answer?.detail ?? FAILED };
  }

  present(answer) {
    this.editor?.mark(null);
    this.output.replaceChildren(...(answer.refusal ? [paragraph("cell-note", answer.refusal)] : this.parts(answer)));
    if (answer.refusal) return;
    this.time.textContent = `${seconds.format(answer.milliseconds / 1000)} s`;
    if (answer.fault?.line) this.edit().then(() => this.editor?.mark(answer.fault.line));
  }

  parts({ stdout, truncated, fault, figures }) {
    const parts = [];
    if (stdout) parts.push(printed(stdout));
    if (truncated) parts.push(paragraph("cell-note", "L’affichage est coupé ici : il est trop long."));
    figures.forEach((address, index) => parts.push(this.figure(address, figures.length > 1 ? ` (${index + 1})` : "")));
    if (fault) parts.push(explained(fault));
    if (!parts.length) parts.push(paragraph("cell-note", "La cellule n’affiche rien : terminez-la par une expression, ou appelez print."));
    return parts;
  }

  figure(address, number) {
    const image = element("img", "cell-figure");
    image.alt = `Figure produite par la cellule ${this.name}${number}`;
    image.addEventListener("load", () => {
      image.style.width = `${image.naturalWidth / DENSITY}px`;
    });
    image.src = address;
    return image;
  }
}

// What the editor offers, where it cannot be had. (Ctrl+Entrée is heard by the cell.)
function plainEditor({ area, text, onChange }) {
  const field = element("textarea", "cell-area");
  field.value = text;
  field.rows = text.split("\n").length + 1;
  field.spellcheck = false;
  field.setAttribute("aria-label", "Votre code Python");
  field.addEventListener("input", onChange);
  area.after(field);
  area.hidden = true;
  return {
    get: () => field.value,
    set: (fresh) => {
      field.value = fresh;
    },
    mark: () => {},
    insert: (typed) => field.setRangeText(typed, field.selectionStart, field.selectionEnd, "end"),
    focus: () => field.focus(),
  };
}

// What is printed may scroll: it is in reach of the keyboard.
function printed(text) {
  const pre = element("pre", "cell-stdout", text);
  pre.tabIndex = 0;
  return pre;
}

function explained({ title, message, frames }) {
  const box = element("div", "cell-fault");
  box.append(element("strong", "", title), paragraph("", message));
  if (frames.length > 1) {
    const list = element("ol", "");
    list.append(...frames.map((frame) => element("li", "", frame)));
    box.append(paragraph("cell-way", "Le chemin jusqu’à l’erreur :"), list);
  }
  return box;
}

function element(tag, className, text = "") {
  const made = document.createElement(tag);
  if (className) made.className = className;
  made.textContent = text;
  return made;
}

function paragraph(className, text) {
  return element("p", className, text);
}

function button(text, action, kind = "") {
  const made = element("button", `button ${kind}`.trim(), text);
  made.type = "button";
  made.addEventListener("click", action);
  return made;
}
