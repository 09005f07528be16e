// How long a test still lasts, from the server's clock: shown each second, said aloud at a few moments only.

import { announce } from "./follow.js";

const SAID_AT = [600, 300, 60]; // seconds before the end
export const LAST_SAVE = 4; // seconds before the end

export function setUpCountdowns() {
  for (const place of document.querySelectorAll("[data-ends]")) start(place);
}

function start(place) {
  const ahead = Date.now() - Date.parse(place.dataset.now); // of this machine's clock on the server's
  const end = Date.parse(place.dataset.ends) + ahead;
  const left = () => Math.ceil((end - Date.now()) / 1000);
  let before = left();
  const tick = () => {
    const seconds = left();
    place.textContent = seconds > 0 ? `il reste ${inWords(seconds)}` : "le temps est écoulé";
    place.classList.toggle("countdown-soon", seconds <= 300);
    const moment = SAID_AT.find((one) => before > one && seconds <= one);
    if (moment && seconds > 0) announce(`Il reste ${inWords(seconds)}.`);
    if (before > LAST_SAVE && seconds <= LAST_SAVE) document.dispatchEvent(new CustomEvent("balise:test-ending"));
    before = seconds;
    if (seconds > 0) return;
    clearInterval(timer);
    announce("Le temps est écoulé. Ce qui est enregistré compte.");
    document.dispatchEvent(new CustomEvent("balise:test-over"));
  };
  const timer = setInterval(tick, 1000);
  tick();
}

function inWords(seconds) {
  const [hours, minutes] = [Math.floor(seconds / 3600), Math.floor((seconds % 3600) / 60)];
  if (hours) return `${hours}\u00a0h\u00a0${String(minutes).padStart(2, "0")}`;
  if (seconds >= 120) return `${minutes}\u00a0min`;
  return minutes ? `${minutes}\u00a0min\u00a0${seconds % 60}\u00a0s` : `${seconds}\u00a0s`;
}
