// Where one is: a bar at the top of the window, and the current heading in the table of contents.

const READING_LINE = 0.3; // of the window's height: what is being read stands above it

export function setUpContents(page) {
  const bar = document.querySelector(".reading-bar span");
  const body = page.querySelector(".reading-body");
  const places = headingsWithLinks(page);
  let due = false;

  function show() {
    due = false;
    const { top, height } = body.getBoundingClientRect();
    const through = (window.innerHeight - top) / Math.max(height, 1);
    bar.style.setProperty("--through", Math.min(1, Math.max(0, through)).toFixed(4));
    mark(places);
  }

  function soon() {
    if (due) return;
    due = true;
    requestAnimationFrame(show);
  }

  window.addEventListener("scroll", soon, { passive: true });
  window.addEventListener("resize", soon);
  show();

  const folded = page.querySelector(".contents-fold");
  folded?.addEventListener("click", (event) => {
    if (event.target.closest("a")) folded.open = false;
  });
}

function headingsWithLinks(page) {
  const places = new Map();
  for (const link of page.querySelectorAll(".contents a")) {
    const heading = document.getElementById(decodeURIComponent(link.hash.slice(1)));
    if (!heading) continue;
    if (!places.has(heading)) places.set(heading, []);
    places.get(heading).push(link);
  }
  return places;
}

let shown = null;
function mark(places) {
  const line = window.innerHeight * READING_LINE;
  let current = null;
  for (const heading of places.keys()) {
    if (heading.getBoundingClientRect().top > line) break;
    current = heading;
  }
  if (current === shown) return;
  for (const link of places.get(shown) ?? []) link.removeAttribute("aria-current");
  if (!current) document.querySelector(".contents-side")?.scrollTo(0, 0);
  for (const link of places.get(current) ?? []) {
    link.setAttribute("aria-current", "location");
    follow(link);
  }
  shown = current;
}

// Keep the current line in sight when the table itself scrolls, without moving the page.
function follow(link) {
  const table = link.closest(".contents-side");
  if (!table || table.scrollHeight <= table.clientHeight) return;
  const above = link.getBoundingClientRect().top - table.getBoundingClientRect().top;
  if (above < 0 || above > table.clientHeight - 40) table.scrollTop += above - table.clientHeight / 2;
}
