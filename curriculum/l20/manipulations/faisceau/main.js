// Six sliders over a histogram of ranges; then EM starts from them, and shows round after round what it would do.

import { causes, histogram, logLikelihood, parts, round, settle } from "./calcul.js";

const COLOURS = ["estimate", "second", "measure", "accent"];
const ROWS = ["hit", "short", "beyond", "random", "sigma", "rate", "told"];
const WORDS = { hit: "α_{hit}", short: "α_{short}", beyond: "α_{max}", random: "α_{rand}", sigma: "σ", rate: "λ", told: "ln p" };
const TICKS = [1, 10, 40, 80];
const RISE = 0.75; // height of the root of one, so that small counts are seen beside large ones
const LAST = 1.1; // where the bar of what saw nothing stands, beyond the axis

export function begin(bench, { data }) {
  const { button, decimal, list, lowered, make } = bench.tools;
  const { read, expected, reach, bin } = data;
  const bins = histogram(read, reach, bin);
  const height = (count) => RISE * Math.sqrt(count);
  let em = null; // { model, rounds, over }
  let values = bench.settings((now) => {
    values = now;
    em = null;
    tell();
  });
  const cells = Object.fromEntries(ROWS.map((name) => [name, [make("td"), make("td")]]));
  const head = make("th", { scope: "col" }, "EM");
  const table = make(
    "table", { class: "hands-table" },
    make("thead", {}, make("tr", {}, make("td"), make("th", { scope: "col" }, "vous"), head)),
    make("tbody", {}, ...ROWS.map((name) => make("tr", {}, make("th", { scope: "row" }, ...lowered(WORDS[name])), ...cells[name]))),
  ); // prettier-ignore
  const one = button("Un tour d’EM", () => go(1));
  const all = button("Jusqu’au bout", () => go(Infinity));
  const back = button("Revenir à vos réglages", () => {
    em = null;
    tell();
    one.focus({ preventScroll: true });
  });
  bench.side.append(table, make("div", { class: "hands-buttons" }, one, all, back));

  function mine() {
    const weights = ["hit", "short", "beyond", "random"].map((name) => Number(values[name]));
    const total = weights.reduce((sum, weight) => sum + weight, 0);
    return { shares: weights.map((weight) => weight / total), sigma: Number(values.sigma), rate: Number(values.rate), reach };
  }

  function go(most) {
    const from = em ?? { model: mine(), rounds: 0 };
    if (most === 1) {
      const next = round(read, expected, from.model);
      if (next) em = { model: next, rounds: from.rounds + 1 };
    } else {
      const found = settle(read, expected, from.model);
      em = { model: found.model, rounds: from.rounds + found.rounds, over: true };
    }
    tell();
  }

  function shown(value) {
    return Number.isFinite(value) ? decimal(value, 1) : "−∞";
  }

  function column(k, model) {
    const told = model && logLikelihood(read, expected, model);
    const numbers = model ? [...model.shares, model.sigma, model.rate].map((value) => decimal(value, 2)) : Array(6).fill("—");
    ROWS.forEach((name, i) => (cells[name][k].textContent = i < 6 ? numbers[i] : model ? shown(told) : "—"));
    return told;
  }

  function tell() {
    const now = mine();
    const told = column(0, now);
    const found = column(1, em?.model ?? null);
    head.textContent = em ? `EM, ${em.rounds} tour${em.rounds > 1 ? "s" : ""}` : "EM";
    back.hidden = em === null;
    all.disabled = Boolean(em?.over) || !Number.isFinite(told);
    one.disabled = all.disabled;
    if (em) {
      const [hit, short, beyond, random] = em.model.shares.map((share) => Math.round(share * read.length));
      bench.say(
        `${em.over ? "EM s’est posé" : "EM en est là"} après ${em.rounds} tour${em.rounds > 1 ? "s" : ""}\u00a0: ln p = ${shown(found)}, ${decimal(found - told, 1)} de plus que vos réglages.`,
        `Sur ${read.length} lectures, il en compte environ ${hit} qui ont touché le mur, ${short} arrêtées avant, ${beyond} qui n’ont rien vu et ${random} de hasard.`,
      );
    } else if (Number.isFinite(told)) {
      bench.say(
        `Le logarithme de la vraisemblance des ${read.length} lectures vaut ${shown(told)}. Faites-le monter.`,
        "Chaque barre est partagée selon la cause que vos réglages donnent à ses lectures.",
      );
    } else {
      bench.say("Une lecture au moins est jugée impossible\u00a0: la vraisemblance est nulle, son logarithme vaut −∞. Laissez une part au hasard.");
    }
    draw(em?.model ?? now);
  }

  /** Of each bin, its bar cut in four, from the causes of the ranges that are in it. */
  function bars(model) {
    const due = causes(read, expected, model);
    const boxes = COLOURS.map(() => []);
    bins.forEach((members, i) => {
      if (members.length === 0) return;
      const left = i === bins.length - 1 ? reach + LAST - bin / 2 : i * bin;
      let count = 0;
      [3, 1, 2, 0].forEach((cause) => {
        const more = members.reduce((sum, k) => sum + (due[k] ? due[k][cause] : cause === 3 ? 1 : 0), 0);
        if (more > 1e-6) boxes[cause].push([left + 0.02, height(count), left + bin - 0.02, height(count + more)]);
        count += more;
      });
    });
    return boxes.map((ones, cause) => ({ kind: "boxes", color: COLOURS[cause], opacity: 0.75, moved: list(ones) }));
  }

  function draw(model) {
    const foreseen = Array.from({ length: 10 * (bins.length - 1) }, (_, k) => {
      const z = ((k + 0.5) * bin) / 10;
      return [z, height(read.length * bin * parts(z, expected, model).reduce((sum, part) => sum + part, 0))];
    });
    const nothing = height(read.length * model.shares[2]);
    bench.paint([
      { kind: "segments", color: "faint", width: 1, opacity: 1, moved: list(TICKS.map((count) => [0, height(count), reach, height(count)])) },
      { kind: "labels", color: "ink", texts: TICKS.map(String), moved: list(TICKS.map((count) => [-0.42, height(count)])) },
      ...bars(model),
      { kind: "polyline", color: "ink", width: 2, moved: list(foreseen) },
      { kind: "segments", color: "ink", width: 2, opacity: 1, moved: list([[reach + LAST - 0.3, nothing, reach + LAST + 0.3, nothing]]) },
      { kind: "polyline", color: "ink", width: 1.5, moved: list([[0, 0], [reach, 0]]) },
      { kind: "labels", color: "ink", texts: ["0", "2", "4", "6", "8", "10", "rien vu"], moved: list([0, 2, 4, 6, 8, 10, reach + LAST - 0.4].map((x) => [x, -0.5])) },
    ]); // prettier-ignore
  }

  tell();
}
