// Somebody is walked in front of the lidar; two formulas say which of two poses they prefer.

import { gaussian, mixture, mixtureOf, ranges } from "./calcul.js";

const CEILING = 20;

export function begin(bench, { data, box }) {
  const { decimal, list, make } = bench.tools;
  let walker = [...data.walker];
  let values = bench.settings((now) => {
    values = now;
    tell();
  });
  const wall = { ...data.walls };
  bench.handle({
    label: "Passant", at: walker, box: [box[0] + 1, box[1] + 1, box[2] - 1, box[3] - 1], step: 0.25,
    moved: (x, y) => {
      walker = [x, y];
      tell();
    },
  }); // prettier-ignore
  const cells = { gaussian: [make("td"), make("td"), make("td")], mixture: [make("td"), make("td"), make("td")] };
  const head = ["ln p", "gaussienne", "mélange"].map((words) => make("th", { scope: "col" }, words));
  const row = (words, k) => make("tr", {}, make("th", { scope: "row" }, words), cells.gaussian[k], cells.mixture[k]);
  bench.side.prepend(
    make(
      "table", { class: "hands-table" },
      make("thead", {}, make("tr", {}, ...head)),
      make("tbody", {}, row("vraie pose", 0), row("fausse pose", 1), row("préférée", 2)),
    ),
  ); // prettier-ignore
  const penalty = bench.chart({
    title: "Ce que coûte le rayon le plus surpris", series: penalties(5), xLabel: "distance lue, en cases", yRange: [0, CEILING], cursor: [5],
  }); // prettier-ignore
  bench.side.append(
    make("p", { class: "hands-help" }, "Tirez le passant, ou prenez-le avec Tab puis les flèches (Maj\u00a0: plus vite). Promenez-le devant les rayons, puis hors de leur chemin."),
  );

  function model() {
    const random = Number(values.hasard);
    const shares = [1 - data.short - data.beyond - random, data.short, data.beyond, random];
    return { sigma: Number(values.sigma), shares, rate: data.rate, reach: data.reach };
  }

  /** What a beam that expects this loses, by what it reads: capped, so that the drawing keeps its scale. */
  function penalties(expected) {
    const one = model();
    const x = Array.from({ length: 121 }, (_, k) => (data.reach * k) / 120);
    const most = mixtureOf(Math.min(expected, data.reach - 1e-6), expected, one);
    const capped = (ones) => ones.map((y) => (y > CEILING ? null : Math.max(0, y)));
    return [
      { label: "gaussienne", color: "alert", style: "dashed", x, y: capped(x.map((z) => (z - expected) ** 2 / (2 * one.sigma ** 2))) },
      { label: "mélange", color: "estimate", style: "line", x, y: capped(x.map((z) => most - mixtureOf(Math.min(z, data.reach - 1e-6), expected, one))) },
    ];
  }

  function tell() {
    const one = model();
    const read = ranges(data.true, data.angles, data.read, data.noise, walker, data.radius);
    const stopped = read.map((z, k) => z !== data.read[k]);
    const count = stopped.filter(Boolean).length;
    const found = {
      gaussian: data.expected.map((expected) => gaussian(read, expected, one.sigma)),
      mixture: data.expected.map((expected) => mixture(read, expected, one)),
    };
    for (const [name, [right, wrong]] of Object.entries(found)) {
      [right, wrong].forEach((value, k) => (cells[name][k].textContent = shown(value)));
      cells[name][2].textContent = right >= wrong ? "la vraie" : "la fausse";
    }
    const surprises = read.map((z, k) => Math.abs(z - data.expected[0][k]));
    const worst = surprises.indexOf(Math.max(...surprises));
    const said = (name, [right, wrong]) =>
      `${name}\u00a0: la ${right >= wrong ? "vraie" : "fausse"} pose l’emporte de ${shown(Math.abs(right - wrong))}`;
    const walked = count === 0 ? "Aucun rayon arrêté" : count === 1 ? "Un rayon arrêté" : `${count} rayons arrêtés`;
    bench.say(
      `${walked} par le passant. ${said("Gaussienne", found.gaussian)}\u00a0; ${said("mélange", found.mixture)} (au logarithme).`,
      `Le rayon le plus surpris lit ${decimal(read[worst], 1)} et attendait ${decimal(data.expected[0][worst], 1)}.`,
    );
    penalty.update({ series: penalties(data.expected[0][worst]), cursor: [read[worst]] });
    draw(read, stopped);
  }

  function shown(value) {
    return Number.isFinite(value) ? decimal(value, Math.abs(value) < 100 ? 1 : 0) : value < 0 ? "−∞" : "∞";
  }

  function draw(read, stopped) {
    const [x, y, heading] = data.true;
    const ends = read.map((z, k) => [x + z * Math.cos(heading + data.angles[k]), y + z * Math.sin(heading + data.angles[k])]);
    const rays = (which, color) => ({
      kind: "segments", color, width: color === "alert" ? 2 : 1, opacity: color === "alert" ? 1 : 0.55,
      moved: list(ends.filter((_, k) => which(k)).map(([ex, ey]) => [x, y, ex, ey])),
    }); // prettier-ignore
    bench.paint([
      wall,
      rays((k) => !stopped[k], "measure"),
      rays((k) => stopped[k], "alert"),
      { kind: "points", color: "measure", size: 2.2, opacity: 1, moved: list(ends.filter((_, k) => !stopped[k] && read[k] < data.reach)) },
      { kind: "points", color: "alert", size: 3, opacity: 1, moved: list(ends.filter((_, k) => stopped[k])) },
      { kind: "circles", color: "alert", radius: data.radius, filled: true, moved: list([walker]) },
      { kind: "pose", color: "estimate", radius: 0.4, style: "ghost", at: data.false },
      { kind: "pose", color: "truth", radius: 0.4, style: "robot", at: data.true },
    ]);
  }

  tell();
}
