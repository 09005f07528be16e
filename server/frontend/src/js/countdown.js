// How long a test still lasts, from the server's clock: shown each second, said aloud at a few moments only. Its page is
// asked now and then, and at the end, whether the end was put off: an end that was told never comes earlier.

import { announce } from "./follow.js";

const SAID_AT = [600, 300, 60]; // seconds before the end
export const LAST_SAVE = 4; // seconds before the end
const ASKED_EVERY = 20; // seconds

export function setUpCountdowns() {
  for (const place of document.querySelectorAll("[data-ends]")) start(place);
}

function start(place) {
  const ahead = Date.now() - Date.parse(place.dataset.now); // of this machine's clock on the server's
  let end = Date.parse(place.dataset.ends) + ahead;
  let asked = Date.now();
  const ask = async () => {
    asked = Date.now();
    const found = await currentEnd(place.dataset.check ?? location.pathname);
    if (!found || Date.parse(found.dataset.ends) + ahead === end) return;
    end = Date.parse(found.dataset.ends) + ahead;
    before = left();
    const shown = place.closest("p")?.querySelector("time");
    const time = found.closest("p")?.querySelector("time");
    if (shown && time) [shown.dateTime, shown.textContent] = [time.dateTime, time.textContent];
    announce(`La fin du contrôle a changé : ${time?.textContent ?? ""}.`);
  };
  const left = () => Math.ceil((end - Date.now()) / 1000);
  let before = left();
  const tick = () => {
    if (Date.now() - asked > 1000 * ASKED_EVERY) ask();
    const seconds = left();
    place.textContent = seconds > 0 ? `il reste ${inWords(seconds)}` : "le temps est écoulé";
    place.classList.toggle("countdown-soon", seconds <= 300);
    const moment = SAID_AT.find((one) => before > one && seconds <= one);
    if (moment && seconds > 0) announce(`Il reste ${inWords(seconds)}.`);
    if (before > LAST_SAVE && seconds <= LAST_SAVE) document.dispatchEvent(new CustomEvent("balise:test-ending"));
    before = seconds;
    if (seconds <= 0) finish();
  };
  const finish = async () => {
    clearInterval(timer);
    await ask(); // it may have been put off since
    if (left() > 0) {
      timer = setInterval(tick, 1000);
      return tick();
    }
    announce("Le temps est écoulé. Ce qui est enregistré compte.");
    document.dispatchEvent(new CustomEvent("balise:test-over"));
  };
  let timer = setInterval(tick, 1000);
  tick();
}

async function currentEnd(path) {
  const response = await fetch(path, { signal: AbortSignal.timeout(3000) }).catch(() => null);
  if (!response?.ok) return null;
  const page = new DOMParser().parseFromString(await response.text(), "text/html");
  return page.querySelector("[data-ends]");
}

function inWords(seconds) {
  const [hours, minutes] = [Math.floor(seconds / 3600), Math.floor((seconds % 3600) / 60)];
  if (hours) return `${hours}\u00a0h\u00a0${String(minutes).padStart(2, "0")}`;
  if (seconds >= 120) return `${minutes}\u00a0min`;
  return minutes ? `${minutes}\u00a0min\u00a0${seconds % 60}\u00a0s` : `${seconds}\u00a0s`;
}
