// Replays of a page: each becomes a player, and asks for its data when it comes near the screen.

import { Player } from "./player.js";

export function enhance(root = document) {
  const figures = [...root.querySelectorAll("figure.replay[data-source]:not([data-ready])")];
  if (figures.length === 0) return;
  const players = new Map();
  const watch = new IntersectionObserver(
    (entries) => entries.forEach((entry) => players.get(entry.target).near(entry.isIntersecting)),
    { rootMargin: "300px 0px" },
  );
  for (const figure of figures) {
    figure.dataset.ready = "";
    players.set(figure, new Player(figure));
    watch.observe(figure);
  }
}
