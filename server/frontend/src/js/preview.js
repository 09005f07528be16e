// A preview: the page comes back at its place once the author's files have changed; what is wrong is shown once known.

const foot = document.getElementById("apercu");
const key = `apercu:${location.pathname}`;

// What one had unfolded stays so; the browser itself keeps where one was, but for pages that grow while they load.
function remember() {
  const open = [...document.querySelectorAll("main details")].map((one) => one.open);
  sessionStorage.setItem(key, JSON.stringify({ y: scrollY, open }));
}

function restore() {
  const kept = JSON.parse(sessionStorage.getItem(key) ?? "null");
  if (!kept) return;
  sessionStorage.removeItem(key);
  const folds = [...document.querySelectorAll("main details")];
  if (folds.length === kept.open.length) folds.forEach((one, place) => (one.open = kept.open[place]));
  scrollTo({ top: kept.y, behavior: "instant" });
}

async function showFaults() {
  const answer = await fetch("/apercu/problemes").catch(() => null);
  if (!answer?.ok) return;
  const fresh = new DOMParser().parseFromString(await answer.text(), "text/html").getElementById("apercu");
  foot.className = fresh.className;
  const link = foot.querySelector("p:has(a)");
  foot.replaceChildren(...fresh.children, ...(link ? [link] : []));
  foot.dataset.looked = fresh.dataset.looked;
}

restore();
const source = new EventSource("/apercu/evenements");
source.addEventListener("version", (event) => {
  if (event.data === foot.dataset.version) return;
  source.close();
  remember();
  location.reload();
});
source.addEventListener("faults", () => foot.dataset.looked === "oui" || showFaults());
addEventListener("pagehide", () => source.close());
