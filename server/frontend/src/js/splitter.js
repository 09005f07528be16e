// The bar between statement and editor: dragged, or moved with the arrow keys.

import { keep, recall } from "./storage.js";

const KEY = "balise-cloison";
const [LEAST, MOST, STEP] = [28, 68, 2];

export function setUpSplitter(bar) {
  if (!bar) return;
  const columns = bar.parentElement;

  function place(percent) {
    const value = Math.round(Math.min(MOST, Math.max(LEAST, percent)));
    columns.style.setProperty("--cloison", `${value}%`);
    bar.setAttribute("aria-valuenow", String(value));
    return value;
  }

  let position = place(Number(recall(KEY)) || 44);
  const move = (percent) => {
    position = place(percent);
    keep(KEY, String(position));
  };

  bar.addEventListener("pointerdown", (event) => {
    bar.setPointerCapture(event.pointerId);
    event.preventDefault();
  });
  bar.addEventListener("pointermove", (event) => {
    if (!bar.hasPointerCapture(event.pointerId)) return;
    const box = columns.getBoundingClientRect();
    move((100 * (event.clientX - box.left)) / box.width);
  });
  bar.addEventListener("keydown", (event) => {
    const change = { ArrowLeft: -STEP, ArrowRight: STEP }[event.key];
    if (change) move(position + change);
    if (event.key === "Home") move(LEAST);
    if (event.key === "End") move(MOST);
  });
}
