// Follow a submission until its verdict: server-sent events, or polling where they do not pass.

const POLL_MS = 1500;

export function announce(text) {
  const region = document.getElementById("annonce");
  if (region) region.textContent = text;
}

// Calls onState({text}) while it waits and resolves once the verdict is there.
export function follow(address, onState) {
  return new Promise((resolve) => {
    if (!window.EventSource) return resolve(poll(address));
    const source = new EventSource(address.events);
    source.addEventListener("status", (event) => {
      const state = JSON.parse(event.data);
      onState(state);
      if (state.status === "done") {
        source.close();
        resolve();
      }
    });
    source.onerror = () => {
      if (source.readyState !== EventSource.CLOSED) return; // the browser reconnects by itself
      resolve(poll(address));
    };
  });
}

async function poll(address) {
  for (;;) {
    const fragment = await fetchFragment(address.verdict);
    if (fragment?.querySelector("[data-status=done]")) return;
    await new Promise((wake) => setTimeout(wake, POLL_MS));
  }
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

// A hint that was open stays open; the folds of a verdict are another verdict's.
function put(part, old) {
  if (part.dataset.part !== "verdict") {
    const folds = part.querySelectorAll("details");
    old.querySelectorAll("details").forEach((fold, place) => {
      if (folds[place]) folds[place].open = fold.open;
    });
  }
  old.replaceWith(part);
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
  await follow(address, (state) => state.status !== "done" && showWaiting(state.text));
  if (!(await refresh(address.verdict))) {
    showWaiting("Le verdict est prêt, mais la page ne parvient pas à le charger. Rechargez-la.");
    return;
  }
  const place = document.querySelector("[data-part=verdict]");
  announce(place?.dataset.announce ?? "");
  if (place && place.getBoundingClientRect().top > window.innerHeight * 0.6) reveal(place, "start");
}

function reveal(place, block) {
  const calm = window.matchMedia("(prefers-reduced-motion: reduce)").matches;
  place.scrollIntoView({ behavior: calm ? "auto" : "smooth", block });
}
