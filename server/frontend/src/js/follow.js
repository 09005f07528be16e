// Follow a submission until its verdict: server-sent events, or polling where they do not pass.

const POLL_MS = 1500;
// A server that is gone without a word ends no stream: whoever has heard nothing for so long looks by themselves.
const LOOK_MS = 10000;

export function announce(text) {
  const region = document.getElementById("annonce");
  if (region) region.textContent = text;
}

// Calls onState({text}) while it waits and resolves once the verdict is there.
export function follow(address, onState) {
  return new Promise((resolve) => {
    if (!window.EventSource) return resolve(poll(address));
    const source = new EventSource(address.events);
    const end = (result) => {
      clearInterval(looking);
      source.close();
      resolve(result);
    };
    let heard = Date.now();
    const looking = setInterval(async () => {
      if (Date.now() - heard >= LOOK_MS && (await isDone(address))) end();
    }, LOOK_MS);
    source.addEventListener("status", (event) => {
      heard = Date.now();
      const state = JSON.parse(event.data);
      onState(state);
      if (state.status === "done") end();
    });
    source.onerror = () => {
      if (source.readyState !== EventSource.CLOSED) return; // the browser reconnects by itself
      end(poll(address));
    };
  });
}

async function poll(address) {
  while (!(await isDone(address))) await new Promise((wake) => setTimeout(wake, POLL_MS));
}

async function isDone(address) {
  return Boolean((await fetchFragment(address.verdict))?.querySelector("[data-status=done]"));
}

async function fetchFragment(url) {
  const response = await fetch(url, { headers: { Accept: "text/html" } }).catch(() => null);
  if (!response?.ok) return null;
  const parsed = new DOMParser().parseFromString(await response.text(), "text/html");
  return parsed.body;
}

// Replace each part of the page that the server sends anew. Returns false when the server cannot be reached.
export async function refresh(url) {
  const fragment = await fetchFragment(url);
  if (!fragment) return false;
  for (const part of fragment.querySelectorAll("[data-part]")) {
    const old = document.querySelector(`[data-part="${part.dataset.part}"]`);
    if (old) put(document.adoptNode(part), old);
  }
  document.dispatchEvent(new CustomEvent("balise:refreshed"));
  return true;
}

// After a verdict, the place of a mistake may be found: its diagnosis then comes by itself, and nothing else moves.
const LATER_SECONDS = [3, 5, 8, 14, 30, 60];

export async function followPlace() {
  for (const seconds of LATER_SECONDS) {
    const place = document.querySelector("[data-part=verdict][data-later]");
    if (!place) return;
    await new Promise((wake) => setTimeout(wake, 1000 * seconds));
    const verdict = (await fetchFragment(place.dataset.later))?.querySelector("[data-part=verdict]");
    if (!verdict || !place.isConnected) continue;
    if (!("later" in verdict.dataset)) delete place.dataset.later;
    const [now, before] = [verdict, place].map((part) => part.querySelector(".diagnosis"));
    if (!now || now.textContent === before?.textContent) continue;
    document.adoptNode(now);
    if (before) before.replaceWith(now);
    else (place.querySelector("#titre-verifications")?.parentElement ?? place.lastElementChild).before(now);
    announce(now.querySelector("h3")?.textContent ?? "");
  }
}

// A hint that was open stays open; the folds of a verdict are another verdict's. Who reads the part goes on there.
function put(part, old) {
  const isRead = old.contains(document.activeElement);
  if (part.dataset.part !== "verdict") {
    const folds = part.querySelectorAll("details");
    old.querySelectorAll("details").forEach((fold, place) => {
      if (folds[place]) folds[place].open = fold.open;
    });
  }
  old.replaceWith(part);
  if (isRead) focusTitle(part);
}

export function focusTitle(part) {
  const title = part.querySelector("h2") ?? part;
  title.tabIndex = -1;
  title.focus({ preventScroll: true });
  return title;
}

export function showWaiting(text) {
  const place = document.querySelector("[data-part=verdict]");
  if (!place) return;
  const line = document.createElement("p");
  line.className = "waiting";
  const dot = document.createElement("span");
  dot.className = "waiting-dot";
  dot.setAttribute("aria-hidden", "true");
  line.append(dot, text);
  place.replaceChildren(line);
  place.dataset.status = "queued";
  place.hidden = false;
  announce(text);
  reveal(place, "nearest");
}

// From the acceptance of a submission to its verdict on the page.
export async function followToVerdict(address) {
  let shown = false;
  await follow(address, (state) => {
    if (state.status === "done") return;
    if (!state.held && !state.early) return showWaiting(state.text);
    if (!shown) showAtOnce(address); // a test holds it back, or its mistake is still sought: what can be said is said
    shown = true;
  });
  if (!(await refresh(address.verdict))) {
    showWaiting("Le verdict est prêt, mais la page ne parvient pas à le charger. Rechargez-la.");
    return;
  }
  const place = document.querySelector("[data-part=verdict]");
  announce(place?.dataset.announce ?? "");
  followPlace();
  if (place && place.getBoundingClientRect().top > window.innerHeight * 0.6) reveal(place, "start");
}

async function showAtOnce(address) {
  await refresh(address.verdict);
  announce(document.querySelector("[data-part=verdict]")?.dataset.announce ?? "");
}

function reveal(place, block) {
  const calm = window.matchMedia("(prefers-reduced-motion: reduce)").matches;
  place.scrollIntoView({ behavior: calm ? "auto" : "smooth", block });
}
