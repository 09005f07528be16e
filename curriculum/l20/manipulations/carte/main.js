// A map that the reader paints, kept in the browser, in which a robot is then lost: the server computes the filter.

import { between, fromText, toText } from "./cases.js";

const KEPT = "balise-carte-dessinee";

export function begin(bench, { data, values: first }) {
  const { button, decimal, keep, list, make, recall } = bench.tools;
  const { rows, columns } = data;
  let { cells, robot } = remembered() ?? asGiven();
  let values = bench.settings((now) => {
    values = now;
    if (bench.film) run();
  });
  const status = make("p", { class: "hands-help", role: "status" });

  function asGiven() {
    return { cells: fromText(first.cases, rows * columns), robot: [...first.robot] };
  }

  function remembered() {
    try {
      const found = JSON.parse(recall(KEPT));
      const kept = fromText(found.cases, rows * columns);
      const place = found.robot;
      const inside = Array.isArray(place) && place.length === 3 && place.every(Number.isFinite)
        && place[0] >= 1 && place[0] <= columns - 1 && place[1] >= 1 && place[1] <= rows - 1; // prettier-ignore
      return kept && inside ? { cells: kept, robot: place } : null;
    } catch {
      return null;
    }
  }

  function save() {
    keep(KEPT, JSON.stringify({ cases: toText(cells), robot }));
  }

  const walled = (column, row) => column <= 0 || row <= 0 || column >= columns - 1 || row >= rows - 1;

  function paint(column, row, wall) {
    if (walled(column, row)) return;
    cells[row * columns + column] = wall;
  }

  // By hand: the first cell that is touched says whether walls are built or taken away.
  let stroke = null;
  const cellOf = (event) => {
    const page = bench.canvas.getBoundingClientRect();
    return bench.stage.paper.back(event.clientX - page.left, event.clientY - page.top).map(Math.floor);
  };
  bench.place.classList.add("hands-paint");
  bench.canvas.addEventListener("pointerdown", (event) => {
    if (bench.film || !event.isPrimary || event.button > 0) return;
    const [column, row] = cellOf(event);
    if (walled(column, row)) return;
    stroke = { wall: !cells[row * columns + column], last: [column, row] };
    bench.canvas.setPointerCapture(event.pointerId);
    paint(column, row, stroke.wall);
    tell();
  });
  bench.canvas.addEventListener("pointermove", (event) => {
    if (!stroke) return;
    const here = cellOf(event);
    for (const [column, row] of between(stroke.last, here)) paint(column, row, stroke.wall);
    stroke.last = here;
    draw();
  });
  for (const end of ["pointerup", "pointercancel"]) {
    bench.canvas.addEventListener(end, () => {
      if (!stroke) return;
      stroke = null;
      save();
      tell();
    });
  }

  // With the keys: a brush that goes from cell to cell.
  const brush = bench.handle({
    label: "Pinceau", at: [1.5, 1.5], box: [1.5, 1.5, columns - 1.5, rows - 1.5], step: 1, look: "hand-cell",
    told: (x, y) => {
      const [column, row] = [Math.floor(x), Math.floor(y)];
      return `ligne ${row + 1}, colonne ${column + 1}\u00a0: ${cells[row * columns + column] ? "mur" : "libre"}`;
    },
    moved: () => draw(),
    key: ({ key }) => {
      if (key !== " " && key !== "Enter") return false;
      const [column, row] = brush.at.map(Math.floor);
      paint(column, row, !cells[row * columns + column]);
      brush.put(...brush.at);
      save();
      tell();
      return true;
    },
  }); // prettier-ignore
  for (const way of ["focus", "blur"]) brush.element.addEventListener(way, () => draw());
  const place = bench.handle({
    label: "Départ du robot", at: robot, box: [1.2, 1.2, columns - 1.2, rows - 1.2], step: 0.5,
    moved: (x, y) => {
      robot = [Number(x.toFixed(2)), Number(y.toFixed(2)), robot[2]];
      save();
      tell();
    },
  }); // prettier-ignore

  function run() {
    const { particules, tirage } = values;
    bench.run({ particules, tirage, lance: "1", robot: robot.join(","), cases: toText(cells) }, status);
  }

  function again(next) {
    ({ cells, robot } = next);
    place.put(robot[0], robot[1]);
    save();
    tell();
  }

  const empty = () => ({ cells: cells.map((_, k) => walled(k % columns, Math.floor(k / columns))), robot });
  const start = button("Lancer le robot", run, "button primary");
  bench.side.prepend(
    make(
      "div", { class: "hands-buttons hands-before" },
      start,
      button("Tout vider", () => again(empty())),
      button("Carte de départ", () => again(asGiven())),
    ),
    make("div", { class: "hands-buttons hands-after" }, button("Retoucher la carte", () => (bench.stop(), tell(), start.focus()))),
    status,
  ); // prettier-ignore
  bench.side.append(
    make(
      "p", { class: "hands-help hands-before" },
      "Peignez au doigt ou à la souris. Au clavier, Tab prend le pinceau\u00a0: les flèches le déplacent, Espace bâtit un mur ou l’ôte. Tab encore prend le robot. Votre carte reste dans ce navigateur.",
    ),
  ); // prettier-ignore

  function tell() {
    const walls = cells.filter((wall, k) => wall && !walled(k % columns, Math.floor(k / columns))).length;
    const inside = cells[Math.floor(robot[1]) * columns + Math.floor(robot[0])];
    bench.say(
      `${walls === 0 ? "Aucun mur" : walls === 1 ? "Un mur" : `${walls} murs`} à l’intérieur. Le robot part de x\u00a0=\u00a0${decimal(robot[0], 1)}, y\u00a0=\u00a0${decimal(robot[1], 1)}${inside ? "\u00a0: c’est un mur, il partira de la case libre la plus proche" : ""}.`,
    );
    draw();
  }

  function draw() {
    const lines = [];
    for (let column = 1; column < columns; column += 1) lines.push([column, 0, column, rows]);
    for (let row = 1; row < rows; row += 1) lines.push([0, row, columns, row]);
    const layers = [
      { kind: "segments", color: "faint", width: 1, opacity: 0.7, moved: list(lines) },
      picture(),
      { kind: "pose", color: "truth", radius: 0.4, style: "robot", at: robot },
    ];
    if (brush.element === document.activeElement) {
      const [x, y] = brush.at;
      const [l, r, t, b] = [x - 0.5, x + 0.5, y - 0.5, y + 0.5];
      layers.push({ kind: "segments", color: "alert", width: 3, opacity: 1, moved: list([[l, t, r, t], [r, t, r, b], [r, b, l, b], [l, b, l, t]]) });
    }
    bench.paint(layers);
  }

  /** The walls as one grid of bytes, in the form that the painter reads. */
  function picture() {
    const bytes = String.fromCharCode(...cells.map((wall) => (wall ? 255 : 0)));
    return { kind: "grid", palette: "walls", corner: [0, 0], cell: 1, w: columns, h: rows, d: btoa(bytes) };
  }

  tell();
}
