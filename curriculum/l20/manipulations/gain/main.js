// Two spreads slide, the measurement is pulled: what the gain believes of it, and what a gain that is too small, or too
// large, costs over twenty steps.

import { bell, fuse, gains, path, typical } from "./calcul.js";

const TALL = 3.4; // of the tallest bell, in the units of the scene
const ROW = -0.95; // where the way from the prediction to the measurement is drawn
const FAR = 3; // standard deviations from which a measurement is a surprise
const POINTS = 161;

export function begin(bench, { data }) {
  const { decimal, list, make } = bench.tools;
  const { predicted, length, move, moves, readings } = data;
  const steps = moves.length;
  let measured = data.measured;
  let values = bench.settings((now) => {
    values = now;
    tell();
  });
  const x = Array.from({ length: POINTS }, (_, k) => (length * k) / (POINTS - 1));
  const step = Array.from({ length: steps }, (_, k) => k + 1);
  const flag = bench.handle({
    label: "Mesure", at: [measured, ROW], box: [0.2, ROW, length - 0.2, ROW], step: 0.1,
    told: (place) => `${decimal(place, 1)} m`,
    moved: (place) => {
      measured = Math.round(10 * place) / 10;
      tell();
    },
  }); // prettier-ignore
  const one = bench.chart({ title: "L’erreur sur un trajet, en m", series: run(compare()), xLabel: "pas", cursor: [steps] });
  const all = bench.chart({ title: "L’erreur typique, en m", series: usual(compare()), xLabel: "pas", yRange: [0, null], cursor: [steps] });
  bench.side.append(
    make("p", { class: "hands-help" }, "Tirez la mesure sous le couloir, ou prenez-la avec Tab puis ← et →. Les curseurs changent la confiance."),
  );

  /** The filter's gains and the reader's, and what becomes of the error with each. */
  function compare() {
    const [spread, noise] = [Number(values.prediction), Number(values.mesure)];
    const from = (fixed) => {
      const used = gains(spread, move, noise, steps, fixed);
      return { used, errors: path(spread, move, noise, used, moves, readings), typical: typical(spread, move, noise, used) };
    };
    return { kalman: from(null), mine: from(Number(values.gain)), small: from(0.05), large: from(1) };
  }

  function run({ kalman, mine }) {
    return [
      { label: "Kalman", color: "estimate", style: "line", x: step, y: kalman.errors },
      { label: "votre gain", color: "accent", style: "dashed", x: step, y: mine.errors },
    ];
  }

  function usual({ kalman, mine, small, large }) {
    return [
      { label: "Kalman", color: "estimate", style: "line", x: step, y: kalman.typical },
      { label: "votre gain", color: "accent", style: "dashed", x: step, y: mine.typical },
      { label: "K = 0,05", color: "second", style: "dots", x: step, y: small.typical },
      { label: "K = 1", color: "measure", style: "dots", x: step, y: large.typical },
    ];
  }

  function tell() {
    const [spread, noise] = [Number(values.prediction), Number(values.mesure)];
    const found = fuse(predicted, spread, measured, noise);
    const compared = compare();
    const last = (curve) => curve.typical[steps - 1];
    const kept = decimal(compared.kalman.used[steps - 1], 2);
    const cost = last(compared.mine) / last(compared.kalman);
    const verdict = cost < 1.05 ? "presque aussi bien que Kalman" : `${decimal(cost, cost < 10 ? 1 : 0)} fois l’erreur de Kalman`;
    bench.say(
      `K = ${decimal(found.gain, 2)}\u00a0: de ${decimal(predicted, 1)} à ${decimal(measured, 1)} m, on fait ${decimal(100 * found.gain, 0)}\u00a0% du chemin. Croyance\u00a0: ${decimal(found.mean, 2)} m, à ${decimal(found.spread, 2)} m près.`,
      found.surprise > FAR
        ? `La mesure est à ${decimal(found.surprise, 1)} écarts-types de ce qu’on attendait\u00a0: le filtre la croit comme une autre, et n’en est pas moins sûr de lui.`
        : `Au bout de ${steps} pas, le gain de Kalman vaut ${kept}, et le vôtre ${decimal(Number(values.gain), 2)}\u00a0: ${verdict}.`,
    );
    one.update({ series: run(compared) });
    all.update({ series: usual(compared) });
    flag.holding || flag.put(measured, ROW);
    draw(found, spread, noise);
  }

  function draw(found, spread, noise) {
    const curves = [[predicted, spread], [measured, noise], [found.mean, found.spread]];
    const scale = TALL / Math.max(...curves.map(([, s]) => bell(0, 0, s)));
    const line = ([mean, s]) => list(x.concat(mean).sort((a, b) => a - b).map((place) => [place, scale * bell(place, mean, s)]));
    const reached = found.mean;
    bench.paint([
      { kind: "polyline", color: "ink", width: 1.5, moved: list([[0, 0], [length, 0]]) },
      { kind: "segments", color: "ink", width: 1, opacity: 0.6, moved: list(Array.from({ length: length + 1 }, (_, k) => [k, 0, k, -0.09])) },
      { kind: "labels", color: "ink", texts: ["2", "4", "6", "8 m"], moved: list([[2, -0.34], [4, -0.34], [6, -0.34], [8, -0.34]]) },
      { kind: "polyline", color: "second", width: 2, dashed: true, moved: line(curves[0]) },
      { kind: "polyline", color: "measure", width: 2, moved: line(curves[1]) },
      { kind: "polyline", color: "estimate", width: 2.6, moved: line(curves[2]) },
      { kind: "segments", color: "estimate", width: 1, opacity: 0.7, dashed: true, moved: list([[reached, ROW, reached, scale * bell(0, 0, found.spread)]]) },
      { kind: "segments", color: "faint", width: 5, opacity: 1, moved: list([[predicted, ROW, measured, ROW]]) },
      { kind: "segments", color: "estimate", width: 5, opacity: 1, moved: list([[predicted, ROW, reached, ROW]]) },
      { kind: "circles", color: "second", radius: 0.13, filled: true, moved: list([[predicted, ROW]]) },
      { kind: "circles", color: "measure", radius: 0.2, filled: true, moved: list([[measured, ROW]]) },
      { kind: "points", color: "estimate", size: 5, opacity: 1, moved: list([[reached, ROW]]) },
    ]); // prettier-ignore
  }

  tell();
}
