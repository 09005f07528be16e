// The variables of a call at a step: those that the last line has changed stand out, and each leads to its next change.

import { make } from "../replays/dom.js";
import { brief } from "./words.js";

const MOST = 60;
const SHORT = new Set(["none", "bool", "number", "text"]);

export class Variables {
  #all = false;

  /** `seek(name, by)`: to the next change of a name (1), or to the one before (−1). `again()` draws all of it anew. */
  constructor({ values, scene, seek, again }) {
    Object.assign(this, { values, scene, seek, again });
    this.element = make("div", { class: "steps-variables" });
  }

  /** Shows `Trace.variables`. */
  show(all) {
    const [variables, tools] = [all.filter((one) => !isTool(one.value)), all.filter((one) => isTool(one.value))];
    const shown = this.#all || variables.length <= MOST ? variables : variables.filter((one, k) => one.changed || k < MOST).slice(0, 2 * MOST);
    const twins = aliases(variables);
    const parts = shown.map((one) => this.#row(one, twins));
    const left = variables.length - shown.length;
    if (left > 0) parts.push(this.#rest(left));
    if (variables.length === 0) parts.push(make("p", { class: "soft" }, "Pas encore de variable."));
    if (tools.length > 0) parts.push(make("p", { class: "soft small" }, `Fonctions et modules\u00a0: ${tools.map((one) => one.name).join(", ")}.`));
    this.element.replaceChildren(...parts);
  }

  #rest(left) {
    const show = () => {
      this.#all = true;
      this.again();
    };
    return make("button", { type: "button", class: "link-button", "data-focus": "rest", onclick: show }, left > 1 ? `Montrer les ${left} autres` : "Montrer l’autre");
  }

  #row({ name, value, changed, fresh, entries, before }, twins) {
    const title = "Aller à son prochain changement (avec Maj : au précédent)";
    const seek = (event) => this.seek(name, event.shiftKey ? -1 : 1);
    const label = make("button", { type: "button", class: "steps-name", title, "data-focus": `name:${name}`, onclick: seek }, name);
    const state = fresh ? "nouvelle" : changed ? "changée" : "";
    const sign = make("span", { class: "steps-sign" }, state);
    const held = make("div", { class: "steps-held" }, this.values.show(value, { key: name, before: changed ? before : null, entries }));
    const was = changed && before ? brief(before) : "";
    if (was && (SHORT.has(before.kind) || /^[[(]/.test(was))) held.append(make("span", { class: "steps-note" }, `avant\u00a0: ${was}`));
    const others = twins.get(value.alias)?.filter((one) => one !== name) ?? [];
    if (others.length > 0) held.append(make("span", { class: "steps-note" }, `le même objet que ${others.slice(0, 3).join(", ")}`));
    const chooser = this.scene.chooser(name, value);
    const short = SHORT.has(value.kind) || value.kind === "other" || held.firstElementChild.matches(".steps-inline");
    const look = `steps-variable${short ? " steps-short" : ""}${changed ? " steps-variable-changed" : ""}`;
    return make("div", { class: look }, ...(short ? [label, held, sign, ...(chooser ? [chooser] : [])] : [make("div", { class: "steps-variable-head" }, label, sign, ...(chooser ? [chooser] : [])), held]));
  }
}

/** What one calls rather than looks at. */
function isTool({ kind, type }) {
  return kind === "other" && ["function", "module", "type", "builtin_function_or_method"].includes(type);
}

/** Of each object that several names hold, these names. */
function aliases(variables) {
  const found = new Map();
  for (const { name, value } of variables) {
    if (value.alias === null || value.alias === undefined) continue;
    found.set(value.alias, [...(found.get(value.alias) ?? []), name]);
  }
  return found;
}
