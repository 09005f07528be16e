// Values and steps in few words: for the sentence of each move, and for the table of steps.

import { french, itemOf } from "./numbers.js";

const MOST_ITEMS = 4;
const MOST_TEXT = 40;
const MOST_NAMES = 4;
const MOST_GIVEN = 24; // characters
const LEVELS = 3;

/** A value in one short line. */
export function brief(value, level = 0) {
  switch (value.kind) {
    case "none": return "None";
    case "bool": return value.value ? "True" : "False";
    case "number": return french(value.text);
    case "text": return quoted(value);
    case "array": return array(value);
    case "sequence": return sequence(value, level);
    case "mapping": return value.length === 0 ? "{ }" : `dictionnaire, ${counted(value.length, "clé")}`;
    default: return other(value);
  } // prettier-ignore
}

/** What stands for an object of which nothing but the type is known. */
export function other({ type, name }) {
  return name ? `${type} ${name}` : type;
}

/** « 16 × 24 ». */
export function shape({ shape: sizes }) {
  return sizes.join("\u00a0×\u00a0");
}

function array(value) {
  const greatest = Math.max(0, ...value.values.map((one) => Math.abs(Number(one)) || 0).filter(Number.isFinite));
  if (value.shape.length === 1 && value.values.length > 0 && value.values.length <= MOST_ITEMS && !value.cut)
    return `[${value.values.map((one) => itemOf(one, value, greatest)).join("\u202f; ")}]`;
  return value.shape.length === 0 ? french(value.values[0] ?? "") : `tableau ${value.shape.length === 1 ? `de ${counted(value.shape[0], "nombre")}` : shape(value)}`;
}

function sequence({ type, items, length }, level) {
  const [open, close] = { list: "[]", tuple: "()" }[type] ?? [`${type}(`, ")"];
  if (level >= LEVELS || length > MOST_ITEMS || items.length < length) return `${named(type)} de ${counted(length, "élément")}`;
  return `${open}${items.map((one) => brief(one, level + 1)).join("\u202f; ")}${close}`;
}

export function named(type) {
  return { list: "liste", tuple: "tuple", set: "ensemble", frozenset: "ensemble figé" }[type] ?? type;
}

export function counted(number, noun) {
  return `${french(String(number))}\u00a0${noun}${number > 1 ? "s" : ""}`;
}

function quoted({ text, length }) {
  const shown = text.slice(0, MOST_TEXT);
  return `«\u202f${shown}${length > shown.length ? "…" : ""}\u202f»`;
}

function listed(names) {
  const shown = names.slice(0, MOST_NAMES);
  const more = names.length - shown.length;
  if (more > 0) return `${shown.join(", ")} et ${more > 1 ? `${more} autres` : "une autre"}`;
  return shown.length > 1 ? `${shown.slice(0, -1).join(", ")} et ${shown.at(-1)}` : (shown[0] ?? "");
}

/** What a function is called: what has none is the file itself, or a part of a line. */
export function nameOf(name) {
  return { "<module>": "le programme", "<lambda>": "une fonction lambda", "<genexpr>": "un générateur" }[name] ?? (name.startsWith("<") ? "une compréhension" : name);
}

/** A call with what it received, where that is short: « fib(5) ». */
export function callOf(trace, frame) {
  const { function: name } = trace.frames[frame];
  const begun = trace.steps[trace.own(frame)[0]];
  if (name.startsWith("<") || begun?.event !== "call") return nameOf(name);
  const given = begun.changes.map((one) => brief(one.value)).join(", ");
  return `${name}(${given.length > MOST_GIVEN ? "…" : given})`;
}

/** What has just happened, and what comes, in one short sentence or two. */
export function sentence(trace, step) {
  const { event, frame, line, changes, gone, value, words } = trace.steps[step];
  const names = changes.map((one) => one.name);
  const lost = gone.length > 0 ? ` ${listed(gone)} n’existe${gone.length > 1 ? "nt" : ""} plus.` : "";
  if (event === "call") return begun(trace.frames[frame].function, names);
  if (event === "exception") return `La ligne ${line} échoue : ${words}`;
  const did = names.length > 0 ? `la ligne ${trace.executed(step) ?? line} change ${listed(names)}.` : "";
  if (event === "return" && failed(trace, step)) return `${capital(nameOf(trace.frames[frame].function))} s’arrête sur une erreur.`;
  if (event === "return") return `${did ? `${capital(did)} ` : ""}${over(trace.frames[frame].function, value)}${lost}`;
  return `Ligne ${line} à exécuter${did ? ` ; ${did}` : "."}${lost}`;
}

function failed(trace, step) {
  const before = trace.beside(step, -1);
  return before !== null && trace.steps[before].event === "exception";
}

function begun(name, names) {
  if (name.startsWith("<")) return `Début : ${nameOf(name)}.`;
  return `Appel de ${name}${names.length > 0 ? `, qui reçoit ${listed(names)}.` : "."}`;
}

function over(name, value) {
  if (name === "<module>") return "Fin du programme.";
  if (value === null) return `Fin : ${nameOf(name)}.`;
  return `${capital(nameOf(name))} renvoie ${articled(brief(value))}.`;
}

function articled(text) {
  return text.replace(/^(?=(?:tableau|tuple|dictionnaire|ensemble) )/, "un ").replace(/^(?=liste )/, "une ");
}

function capital(text) {
  return /^(le|la|une|un) /.test(text) ? text[0].toUpperCase() + text.slice(1) : text;
}
