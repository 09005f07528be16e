// What one has read, kept in this browser for each account: a section is read when its end has been seen, after a time
// that suits its length. Nothing is sent anywhere.

import { keep, recall } from "../storage.js";

const VISITOR = "visiteur";
const WORDS_PER_SECOND = 15; // three times faster than one reads: only what was flown over is left out
const LONGEST = 30; // seconds
const TICK = 1; // seconds

export function setUpReadMarks(page) {
  const [module, slug] = page.dataset.reading.split("/");
  const notes = new Notes(page.dataset.account, module);
  const sections = sectionsOf(page.querySelector(".reading-body"));
  const state = page.querySelector("[data-read-state]");
  if (!sections.length) return;

  const read = new Set(notes.of(slug));

  function show() {
    for (const section of sections) {
      const known = read.has(section.id);
      for (const link of page.querySelectorAll(`.contents a[href="#${CSS.escape(section.id)}"]`)) markLink(link, known);
    }
    showState(state, sections.filter((one) => read.has(one.id)).length, sections.length, change);
  }

  function change(all) {
    for (const section of sections) {
      if (all) read.add(section.id);
      else read.delete(section.id);
      section.seen = all ? section.needed : 0;
    }
    notes.write(slug, [...read]);
    show();
  }

  function tick() {
    if (document.hidden) return;
    const before = read.size;
    for (const section of sections) {
      if (!read.has(section.id) && section.isRead()) read.add(section.id);
    }
    if (read.size === before) return;
    notes.write(slug, [...read]);
    show();
  }

  show();
  setInterval(tick, TICK * 1000);
}

// The page's parts, from one heading of level 2 to the next.
function sectionsOf(body) {
  const sections = [];
  for (const element of body.children) {
    if (element.tagName === "H2" && element.id) sections.push(new Section(element));
    else sections.at(-1)?.add(element);
  }
  return sections;
}

class Section {
  constructor(heading) {
    this.id = heading.id;
    this.first = this.last = heading;
    this.words = 0;
    this.seen = 0;
    this.endSeen = false;
  }

  add(element) {
    this.last = element;
    this.words += element.textContent.length / 6;
  }

  get needed() {
    return Math.min(LONGEST, this.words / WORDS_PER_SECOND);
  }

  isRead() {
    const top = this.first.getBoundingClientRect().top;
    const bottom = this.last.getBoundingClientRect().bottom;
    if (top < window.innerHeight * 0.8 && bottom > 0) this.seen += TICK;
    if (bottom > 0 && bottom <= window.innerHeight + 8) this.endSeen = true;
    return this.endSeen && this.seen >= this.needed;
  }
}

function markLink(link, known) {
  if (link.classList.contains("read") === known) return;
  link.classList.toggle("read", known);
  link.querySelector(".visually-hidden")?.remove();
  if (!known) return;
  const word = document.createElement("span");
  word.className = "visually-hidden";
  word.textContent = " (lue)";
  link.append(word);
}

function showState(state, done, total, change) {
  const button = document.createElement("button");
  button.type = "button";
  button.className = "link-button";
  button.textContent = done < total ? "Tout marquer comme lu" : "Marquer comme à relire";
  button.addEventListener("click", () => {
    change(done < total);
    state.querySelector("button").focus();
  });
  state.replaceChildren(`${sentence(done, total)} `, button);
  state.hidden = false;
}

function sentence(done, total) {
  if (!done) return "Aucune section n’est encore lue.";
  if (done === total) return total === 1 ? "Vous avez lu cette page." : "Vous avez lu toute cette page.";
  return `Vous avez lu ${done} section${done > 1 ? "s" : ""} sur ${total}.`;
}

// On the module's page: how far each text has been read, and where to go on.
export function showCourseMarks(course) {
  const notes = new Notes(course.dataset.account, course.dataset.course);
  for (const place of course.querySelectorAll("[data-read-of]")) {
    const total = Number(place.dataset.parts);
    const done = Math.min(total, notes.of(place.dataset.readOf).length);
    if (!done) continue;
    place.textContent = done === total ? "lue en entier" : `${done} section${done > 1 ? "s" : ""} sur ${total}`;
    place.toggleAttribute("data-done", done === total);
    place.hidden = false;
  }
  goOn(course, notes);
}

function goOn(course, notes) {
  const start = course.querySelector("[data-start]");
  const begun = [...course.querySelectorAll(".session")].map((card) => {
    const place = card.querySelector("[data-read-of]");
    return { card, done: notes.of(place.dataset.readOf).length, total: Number(place.dataset.parts) };
  });
  if (!start || !begun.some((one) => one.done)) return;
  const next = begun.find((one) => one.done < one.total);
  if (!next) return;
  const link = next.card.querySelector("h3 a");
  start.href = link.href;
  start.textContent = `${next.done ? "Reprendre" : "Continuer"} : ${next.card.querySelector(".eyebrow").textContent}`;
}

class Notes {
  constructor(account, module) {
    this.key = `balise-lu:${account}:${module}`;
    if (account !== VISITOR && recall(this.key) === null) this.adopt(`balise-lu:${VISITOR}:${module}`);
    this.pages = parse(recall(this.key));
  }

  // A visitor who becomes somebody keeps what was read.
  adopt(visitors) {
    const found = recall(visitors);
    if (found !== null && keep(this.key, found)) keep(visitors, null);
  }

  of(slug) {
    const list = this.pages[slug];
    return Array.isArray(list) ? list : [];
  }

  write(slug, ids) {
    this.pages = { ...parse(recall(this.key)), [slug]: ids };
    keep(this.key, JSON.stringify(this.pages));
  }
}

// What another version, or a curious reader, wrote there may be anything.
function parse(text) {
  try {
    const value = JSON.parse(text ?? "{}");
    return value && typeof value === "object" ? value : {};
  } catch {
    return {};
  }
}
