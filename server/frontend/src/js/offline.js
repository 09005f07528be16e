// The pages of an archive, opened from a folder without a server: one plain script, since browsers refuse modules there.
// A replay has come along with the settings that it begins with, as a script too, since they refuse to fetch as well.

import { enhance as enhanceHands } from "./manipulations/index.js";
import { Origin } from "./manipulations/load.js";
import { setUpContents } from "./reading/contents.js";
import { setUpDrawings } from "./reading/drawings.js";
import { setUpFormulas } from "./reading/formulas.js";
import { setUpPrinting } from "./reading/print.js";
import { setUpTerms } from "./reading/terms.js";
import { enhance } from "./replays/index.js";
import { Source } from "./replays/source.js";

const scenes = (globalThis.baliseScenes = {});
const hands = (globalThis.baliseHands = {});
const reading = document.querySelector("[data-reading]");

/** With the settings that it begins with, or those of its prediction: any others are the server's to compute. */
Source.answer = async (address, settings) => {
  const name = address.split("/").at(-1).replace(/\.js$/, "");
  if (!(name in scenes)) await brought(address);
  return scenes[name][JSON.stringify(Object.entries(settings).sort())] ?? scenes[name]["[]"];
};

// A manipulation that needs no server has come along with what it begins with, and its scripts as texts.
const handsOf = async (address) => {
  const name = address.split("/").at(-1).replace(/\.js$/, "");
  if (!(name in hands)) await brought(address);
  return hands[name];
};
Origin.answer = async (address) => (await handsOf(address)).scene;
Origin.script = async (address) => import(moduleOf("main.js", (await handsOf(address)).scripts));

/** A script as a module that stands alone: what it imports from its folder is within its address, in the same way. */
function moduleOf(name, scripts) {
  const text = scripts[name].replace(/(\bfrom\s+")\.\/([\w-]+\.js)(?=")/g, (_, from, file) => from + moduleOf(file, scripts));
  return `data:text/javascript;charset=utf-8,${encodeURIComponent(text)}`;
}

function brought(address) {
  return new Promise((done, failed) => {
    const script = document.createElement("script");
    script.src = address;
    script.onload = done;
    script.onerror = () => failed(new Error("Son fichier manque dans l’archive."));
    document.head.append(script);
  });
}

function note(words) {
  const line = document.createElement("p");
  line.className = "offline-note soft small";
  line.textContent = words;
  return line;
}

if (reading) {
  setUpDrawings(reading);
  setUpTerms(reading);
  if (document.querySelector(".reading-bar")) setUpContents(reading);
  setUpPrinting(reading);
  setUpFormulas(reading);
  for (const figure of reading.querySelectorAll("figure.manipulation")) {
    if (figure.dataset.hands.endsWith(".js")) continue;
    delete figure.dataset.hands;
    figure.querySelector(".replay-stage").remove();
    figure.querySelector(".without-script").classList.remove("without-script");
    figure.append(note("Hors ligne, ce dessin ne se laisse pas prendre en main : il faut le serveur du cours."));
  }
  for (const figure of reading.querySelectorAll("figure.replay[data-source]"))
    figure.append(note("Hors ligne, les réglages de l’animation ne se changent pas : le serveur du cours les calcule."));
  enhance(reading);
  enhanceHands(reading);
}
