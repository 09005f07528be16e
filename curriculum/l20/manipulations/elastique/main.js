// σ and n slide, the end of the chain is pulled: how an error spreads along it, and how a closure shares it out.

import { chain } from "./calcul.js";

export function begin(bench, { data }) {
  const { decimal, list, make } = bench.tools;
  const { length, reach, rows } = data;
  let gap = data.gap;
  let values = bench.settings((now) => {
    values = now;
    tell();
  });
  const flag = bench.handle({
    label: "Où la fermeture place la dernière pose", at: [length + gap, rows[0]],
    box: [length - reach, rows[0], length + reach, rows[0]], step: 0.05,
    told: (x) => `écart de ${signed(x - length)} m`,
    moved: (x) => {
      gap = Math.round((x - length) * 100) / 100;
      tell();
    },
  }); // prettier-ignore
  const spread = bench.chart({ title: "Écart-type de chaque pose, en cm", series: curves(solve()), xLabel: "pose", cursor: [0] });
  bench.side.append(
    make("p", { class: "hands-help" }, "Tirez le repère rouge, ou prenez-le avec Tab puis ← et →. Les curseurs changent la chaîne."),
  );

  function solve() {
    return chain(Number(values.n), Number(values.sigma) / 100, Number(values.borne) / 100, gap);
  }

  function signed(value) {
    return `${value >= 0 ? "+" : ""}${decimal(value, 2)}`;
  }

  function centimetres(value) {
    return `${decimal(100 * value, Math.abs(value) < 0.1 ? 2 : 1)}\u00a0cm`;
  }

  function curves({ open, closed }) {
    const cm = (ones) => ones.map((one) => 100 * one);
    const x = open.map((_, k) => k);
    return [
      { label: "sans fermeture", color: "second", style: "dashed", x, y: cm(open) },
      { label: "fermée", color: "estimate", style: "line", x, y: cm(closed) },
    ];
  }

  function tell() {
    const found = solve();
    const last = found.open.length - 1;
    const middle = Math.max(...found.closed);
    bench.say(
      `Chaque maillon cède de ${centimetres(found.each)}, la fermeture garde ${centimetres(found.left)}. χ² = ${decimal(found.chi2, 2)}.`,
      `Écart-type de la dernière pose\u00a0: de ${centimetres(found.open[last])} à ${centimetres(found.closed[last])}\u00a0; le plus grand de la chaîne fermée\u00a0: ${centimetres(middle)}.`,
    );
    spread.update({ series: curves(found), cursor: [last] });
    flag.holding || flag.put(length + gap, rows[0]);
    draw(found);
  }

  function draw({ shifts, open, closed }) {
    const last = shifts.length - 1;
    const places = shifts.map((_, k) => (length * k) / last);
    const layers = [];
    for (const [row, moved, widths] of [[rows[0], shifts.map(() => 0), open], [rows[1], shifts, closed]]) {
      const along = places.map((x, k) => x + moved[k]);
      for (const side of [-1, 1]) {
        layers.push({ kind: "polyline", color: "second", width: 1.6, moved: list(along.map((x, k) => [x, row + side * widths[k]])) });
      }
      layers.push(
        { kind: "polyline", color: "estimate", width: 1.5, moved: list(along.map((x) => [x, row])) },
        { kind: "points", color: "estimate", size: last > 50 ? 2.5 : 4, opacity: 1, moved: list(along.map((x) => [x, row])) },
        { kind: "segments", color: "alert", width: 3, opacity: 1, moved: list([[length + gap, row - 0.5, length + gap, row + 0.5]]) },
      );
      if (moved[last] !== 0) {
        const slid = places.map((x, k) => [x, row + 0.7, along[k], row]);
        layers.push({ kind: "segments", color: "measure", width: 1.5, opacity: 1, moved: list(slid) });
      }
    }
    layers.push(
      { kind: "segments", color: "alert", width: 1.5, dashed: true, opacity: 1, moved: list([[length, rows[0], length + gap, rows[0]]]) },
      { kind: "circles", color: "alert", radius: 0.3, filled: true, moved: list([[length + gap, rows[0]]]) },
      {
        kind: "labels", color: "ink", texts: ["avant la fermeture", "après"],
        moved: list([[1.5, rows[0] - 1.6], [-0.1, rows[1] - 1.6]]),
      },
    ); // prettier-ignore
    bench.paint(layers);
  }

  tell();
}
