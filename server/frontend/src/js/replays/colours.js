// Colours have names; what they look like is the style sheet's to say, for the theme in force.

const MEANINGS = ["truth", "estimate", "measure", "alert", "second", "ink", "faint", "accent"];
const NAMES = [...MEANINGS, "paper", "wall", "unknown", "surface"];

/** The colours of a replay as [red, green, blue], by name. */
export function readColours(stage) {
  const probe = document.createElement("span");
  probe.hidden = true;
  stage.append(probe);
  const found = {};
  for (const name of NAMES) {
    probe.style.color = `var(--replay-${name})`;
    found[name] = getComputedStyle(probe).color.match(/[\d.]+/g).slice(0, 3).map(Number);
  }
  probe.remove();
  return found;
}

export function css([red, green, blue], opacity = 1) {
  return `rgb(${red} ${green} ${blue} / ${opacity})`;
}

export function onThemeChange(callback) {
  const later = () => requestAnimationFrame(callback);
  new MutationObserver(later).observe(document.documentElement, { attributeFilter: ["data-theme"] });
  window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", later);
}

function mix(from, to, part) {
  return from.map((value, i) => value + part * (to[i] - value));
}

/** For each palette, what a number of [0, 1] looks like: [red, green, blue, opacity]. */
const PALETTES = {
  walls: (v, of) => [...of.wall, v],
  occupancy: (v, of) => [...(v < 0.5 ? mix(of.paper, of.unknown, 2 * v) : mix(of.unknown, of.wall, 2 * v - 1)), 1],
  belief: (v, of) => [...mix(of.estimate, of.alert, v * v), v > 0 ? 0.06 + 0.94 * v ** 0.7 : 0],
  cost: (v, of) => [...mix(of.estimate, of.alert, v), 0.8 * v],
  order: (v, of) => [...mix(of.accent, of.second, v), v > 0 ? 0.45 : 0],
  difference: (v, of) => [...(v < 0.5 ? of.truth : of.alert), Math.min(1, 1.6 * Math.abs(2 * v - 1))],
};

/** The 256 colours of a palette, four bytes each. */
export function ramp(palette, colours) {
  const table = new Uint8ClampedArray(1024);
  for (let byte = 0; byte < 256; byte += 1) {
    const [red, green, blue, opacity] = PALETTES[palette](byte / 255, colours);
    table.set([red, green, blue, 255 * opacity], 4 * byte);
  }
  return table;
}
