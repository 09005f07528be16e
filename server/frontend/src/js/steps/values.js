// Values as elements of the page: numbers, grids of numbers with what has changed, lists and dictionaries that unfold.

import { make } from "../replays/dom.js";
import { exact, exactItem, french, itemOf } from "./numbers.js";
import { changedCells, picture } from "./picture.js";
import { brief, counted, named, other, shape } from "./words.js";

const MOST_CELLS = 64; // of an array that is shown at once; a larger one is drawn, and unfolds
const MOST_COLUMNS = 12;
const MOST_ITEMS = 12;
const [WIDE, FEWER_DIGITS] = [5, 4]; // columns from which numbers are written shorter
const MOST_TOLD = 3; // changes of a large array that are told one by one
const LEVELS = 6;
const NESTED = new Set(["array", "sequence", "mapping"]); // in which what differs is marked itself

export class Values {
  #open = new Set();
  exactly = false;

  /** An element for a value; `key` names its place, so that what is unfolded stays so; `before` what stood there. */
  show(value, { key, before = null, entries = [], level = 0 }) {
    switch (value.kind) {
      case "number": return this.#number(value);
      case "text": return make("span", { class: "steps-text" }, this.#text(value));
      case "array": return this.#array(value, { key, before, entries });
      case "sequence": return this.#sequence(value, { key, before, level });
      case "mapping": return this.#mapping(value, { key, before, level });
      case "other": return make("span", { class: "soft" }, other(value));
      default: return make("span", {}, brief(value));
    } // prettier-ignore
  }

  #number({ text, type }) {
    const written = this.exactly ? exact(text) : french(text);
    return make("span", { class: "steps-figure", title: `${exact(text)} (${type})` }, written);
  }

  #text({ text, length }) {
    const more = length - text.length;
    return `«\u202f${text}\u202f»${more > 0 ? ` et ${counted(more, "caractère")} de plus` : ""}`;
  }

  #array(value, { key, before, entries }) {
    if (value.shape.length === 0) return this.#number({ text: value.values[0] ?? "", type: value.dtype });
    const [total, columns] = [value.shape.reduce((a, b) => a * b, 1), value.shape.at(-1)];
    if (total === 0) return note(`tableau vide, de forme ${shape(value)}`);
    if (value.values.length === 0) return note(`tableau ${shape(value)}, ${value.dtype}`);
    const large = value.cut || total > MOST_CELLS || columns > MOST_COLUMNS;
    const told = `${value.shape.length === 1 ? counted(total, "valeur") : shape(value)}${value.dtype === "float64" ? "" : `, ${value.dtype}`}`;
    const drawn = large || value.shape.length === 1 ? picture(value, entries) : null;
    const above = drawn ? [drawn] : [];
    const special = value.shape.length > 2 || value.dtype !== "float64";
    if (!large) return make("div", { class: "steps-array" }, ...above, this.#grid(value, before, entries), note(told, special));
    const changes = entries.length > 0 ? ` ; ${changedCells(entries.length)}` : "";
    const cut = value.cut ? ` ; seules les ${value.values.length} premières valeurs sont là` : "";
    const whole = this.#fold(key, `Tableau ${value.shape.length === 1 ? "de " : ""}${told}${cut}${changes}`, () => [this.#grid(value, before, entries)]);
    const few = entries.length > 0 && entries.length <= MOST_TOLD ? [make("span", { class: "steps-changes" }, entries.map((k) => this.#change(value, before, k)).join("\u202f; "))] : [];
    return make("div", { class: "steps-array" }, ...above, ...few, whole);
  }

  /** « [2, 3] : 0 → 0,8 ». */
  #change(value, before, place) {
    const written = (text) => (this.exactly ? exactItem(text, value) : itemOf(text, value, 0));
    const was = before?.kind === "array" && before.values[place] !== undefined ? `${written(before.values[place])} → ` : "";
    return `${indices(value.shape, place)}\u00a0: ${was}${written(value.values[place])}`;
  }

  #grid(array, before, entries) {
    const { shape: sizes, values } = array;
    const columns = sizes.at(-1);
    const changed = new Set(entries);
    const greatest = Math.max(0, ...values.map((one) => Math.abs(Number(one))).filter(Number.isFinite));
    const written = (text) => (this.exactly ? exactItem(text, array) : itemOf(text, array, greatest, columns > WIDE ? FEWER_DIGITS : undefined));
    const rows = [];
    for (let start = 0; start < values.length; start += columns) {
      const cells = values.slice(start, start + columns).map((text, k) => {
        if (!changed.has(start + k)) return make("td", { title: exactItem(text, array) }, written(text));
        const was = before?.kind === "array" ? before.values[start + k] : undefined;
        const title = `${exactItem(text, array)}${was === undefined ? "" : ` (avant\u00a0: ${exactItem(was, array)})`}`;
        return make("td", { class: "steps-changed", title }, make("mark", {}, written(text)));
      });
      rows.push(make("tr", {}, ...cells));
    }
    const table = make("table", { class: "matrix" }, make("tbody", {}, ...rows));
    return make("div", { class: "steps-grid", tabindex: "0", role: "group", "aria-label": "valeurs" }, table);
  }

  #sequence(value, { key, before, level }) {
    const { items, length, type } = value;
    if (length === 0) return make("span", { class: "steps-inline" }, type === "tuple" ? "( )" : type === "list" ? "[ ]" : `${named(type)} vide`);
    if (level >= LEVELS) return note(brief(value));
    const old = before?.kind === "sequence" ? before.items : null;
    const shown = items.map((item, k) => [`[${k}]`, item, old?.[k]]);
    if (flat(items) && length <= MOST_ITEMS) return this.#inline(value, old);
    return this.#listed(shown, length, `${named(type)} de ${counted(length, "élément")}`, { key, level, old });
  }

  #mapping(value, { key, before, level }) {
    if (value.length === 0) return make("span", { class: "steps-inline" }, "{ }");
    if (level >= LEVELS) return note(brief(value));
    const old = before?.kind === "mapping" ? new Map(before.items.map(([name, item]) => [JSON.stringify(name), item])) : null;
    const shown = value.items.map(([name, item]) => [brief(name), item, old?.get(JSON.stringify(name))]);
    return this.#listed(shown, value.length, brief(value), { key, level, old });
  }

  /** Numbers and the like, side by side between the signs of their type. */
  #inline({ items, type }, old) {
    const [open, close] = { list: "[]", tuple: "()" }[type] ?? [`${type}(`, ")"];
    const parts = items.flatMap((item, k) => {
      const shown = this.show(item, { key: "" });
      return [k > 0 ? "\u202f; " : "", old && !same(item, old[k]) ? make("mark", {}, shown) : shown];
    });
    return make("span", { class: "steps-inline" }, open, ...parts, close);
  }

  #listed(shown, length, told, { key, level, old }) {
    const rows = () => {
      const parts = shown.map(([name, item, was]) => {
        const changed = old && !same(item, was);
        const inside = this.show(item, { key: `${key}${name}`, before: changed ? was : null, level: level + 1 });
        return make("li", changed ? { class: "steps-changed" } : {}, make("code", { class: "soft" }, name), changed && !NESTED.has(item.kind) ? make("mark", {}, inside) : inside);
      });
      const left = length - shown.length;
      if (left > 0) parts.push(make("li", { class: "soft" }, `et ${counted(left, "autre")}`));
      return [make("ul", { class: "steps-list", role: "list" }, ...parts)];
    };
    if (length <= MOST_ITEMS && level === 0) return make("div", {}, note(told), ...rows());
    return this.#fold(key, told, rows);
  }

  /** What is made only once it is unfolded. */
  #fold(key, told, inside) {
    const details = make("details", { class: "steps-fold", open: this.#open.has(key) }, make("summary", { "data-focus": `fold:${key}` }, told));
    if (details.open) details.append(...inside());
    details.addEventListener("toggle", () => {
      if (details.open === this.#open.has(key)) return;
      if (details.open) this.#open.add(key);
      else this.#open.delete(key);
      if (details.open && details.childElementCount === 1) details.append(...inside());
    });
    return details;
  }
}

/** Whether two values are the same, whatever objects they are. */
export function same(a, b) {
  const plain = (name, value) => (name === "alias" ? undefined : value);
  return JSON.stringify(a, plain) === JSON.stringify(b, plain);
}

/** « [2, 3] », of the place of an item among all. */
function indices(shape, place) {
  const found = [];
  let rest = place;
  for (const size of [...shape].reverse()) {
    found.unshift(rest % size);
    rest = Math.floor(rest / size);
  }
  return `[${found.join(", ")}]`;
}

function flat(items) {
  return items.every((one) => ["number", "bool", "none"].includes(one.kind));
}

function note(words, shown = true) {
  return make("span", { class: "steps-note", hidden: !shown }, words);
}
