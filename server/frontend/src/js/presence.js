// Whoever works without opening a page is there all the same: their class's page would take them for absent.

const INTERVAL = 5 * 60_000;
const SIGNS = ["keydown", "pointerdown", "scroll"];

export function showPresence(address) {
  if (!address) return;
  let told = Date.now(); // the page itself told it
  const tell = () => {
    if (Date.now() - told < INTERVAL) return;
    told = Date.now();
    fetch(address, { cache: "no-store" }).catch(() => {}); // without a network nobody is seen
  };
  for (const sign of SIGNS) addEventListener(sign, tell, { passive: true, capture: true });
}
