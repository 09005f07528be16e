// Small helpers to build what a player is made of.

/** An element with attributes (false and null are left out), listeners (`onclick`…) and children. */
export function make(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else if (value === true) element.setAttribute(name, "");
    else if (value !== false && value !== null) element.setAttribute(name, value);
  }
  element.append(...children);
  return element;
}

export function button(text, onclick, look = "button") {
  return make("button", { type: "button", class: look, onclick }, text);
}

/** A small mark in one of the scene's colours: what it stands for is said beside it. */
export function mark(symbol, color) {
  return make("i", { class: `replay-mark replay-mark-${symbol}`, style: `color: var(--replay-${color})` });
}

const SVG = "http://www.w3.org/2000/svg";

/** A drawing of 24 × 24 made of one path. */
export function icon(path) {
  const svg = document.createElementNS(SVG, "svg");
  svg.setAttribute("viewBox", "0 0 24 24");
  svg.setAttribute("aria-hidden", "true");
  const line = document.createElementNS(SVG, "path");
  line.setAttribute("d", path);
  svg.append(line);
  return svg;
}

/** What keys do, as a list: of each line the keys, apart by a space, then the words. */
export function keyList(lines) {
  const rows = lines.map(([names, words]) => {
    const keys = names.split(" ").flatMap((name) => [make("kbd", {}, name), " "]);
    return make("div", {}, make("dt", {}, ...keys), make("dd", {}, words));
  });
  return make("dl", {}, ...rows);
}

/** Text in which _{…} is lowered. */
export function lowered(text) {
  const parts = text.split(/_\{([^}]*)\}/);
  return parts.map((part, i) => (i % 2 ? make("sub", {}, part) : part));
}

export function decimal(value, decimals) {
  return value.toFixed(decimals).replace("-", "−").replace(".", ",");
}
