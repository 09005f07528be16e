// On every page: the theme switch, confirmations, submissions that are still waiting.

import { setUpCountdowns } from "./countdown.js";
import { setUpColumnMarks } from "./columns.js";
import { noteAccount } from "./drafts.js";
import { setUpFieldCopies } from "./fields.js";
import { followPlace, followToVerdict } from "./follow.js";
import { setUpSearchKey } from "./search.js";
import { showPresence } from "./presence.js";
import { followProgress } from "./progress.js";
import { setUpTheme, showTheme } from "./themes.js";
import { setUpVerdictKey } from "./verdict_key.js";

setUpTheme();
noteAccount();

// Dates are those of the school's clock, as the server writes them: a deadline reads the same for everyone. Whose own
// clock says something else is told that beside it.
function showLocalTimes() {
  const clock = (timeZone) => new Intl.DateTimeFormat("fr-FR", { dateStyle: "short", timeStyle: "short", timeZone });
  const [school, own] = [clock(document.body.dataset.zone), clock()];
  for (const time of document.querySelectorAll("time[datetime]:not([data-own])")) {
    const when = new Date(time.dateTime);
    time.dataset.own = "";
    if (school.format(when) === own.format(when)) continue;
    const beside = document.createElement("span");
    beside.className = "own-clock";
    beside.textContent = ` (chez vous : ${own.format(when).replace(":", "\u00a0h\u00a0")})`;
    time.append(beside);
  }
}

// Only those in sight: the others are not even asked for yet, and what moves, seen or not, is drawn at every frame.
const pictures = new IntersectionObserver((changes) => {
  for (const { target, isIntersecting } of changes) {
    target.toggleAttribute("data-awaited", isIntersecting && !target.complete);
  }
});

function markAwaitedPictures() {
  for (const image of document.querySelectorAll(":is(.drawing, .figure, .session-figure) img")) {
    if (!image.complete) pictures.observe(image);
  }
}

// Neither event bubbles.
for (const end of ["load", "error"]) {
  document.addEventListener(end, ({ target }) => target.removeAttribute?.("data-awaited"), true);
}

// What a program did, on the page of its verdict: the player is fetched with the first of them.
function showFilms() {
  if (!document.querySelector(".film figure.replay:not([data-ready])")) return;
  import("./replays/index.js").then(({ enhance }) => enhance());
}

document.addEventListener("click", (event) => {
  const link = event.target.closest?.("a[href^='#film-']");
  const film = link && document.getElementById(link.hash.slice(1));
  if (!film) return;
  event.preventDefault(); // going to an address takes the focus from what it names
  film.open = true;
  film.scrollIntoView({ block: "start" });
  film.querySelector("summary").focus({ preventScroll: true });
});

// A counterexample line by line: what shows it is fetched with the first of them.
document.addEventListener("click", (event) => {
  const asking = event.target.closest?.("button[data-steps]");
  if (asking) import("./steps/index.js").then(({ replay }) => replay(asking));
});

function dress() {
  showFilms();
  showTheme();
  showLocalTimes();
  markAwaitedPictures();
}

document.addEventListener("balise:refreshed", dress);
dress();
setUpSearchKey();
setUpFieldCopies();
setUpColumnMarks();
setUpCountdowns();
setUpVerdictKey();

// Once its time is over, the page of a test says what comes next.
document.addEventListener("balise:test-over", () => setTimeout(() => location.reload(), 3000));

document.querySelector("[data-print-page]")?.addEventListener("click", () => window.print());

document.addEventListener("submit", (event) => {
  const question = event.target.dataset?.confirm;
  if (question && !window.confirm(question)) event.preventDefault();
});

const waiting = document.querySelector("[data-part=verdict][data-events]");
if (waiting && waiting.dataset.status !== "done") {
  followToVerdict({ events: waiting.dataset.events, verdict: waiting.dataset.verdict });
}

followPlace();
followProgress();
showPresence(document.body.dataset.presence);
