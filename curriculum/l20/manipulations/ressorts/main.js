// Poses that are dragged, springs coloured by their χ², closures that are cut and tied, and Gauss-Newton.

import { KERNELS, cost, doubted, edgeChi2, step, weights } from "./calcul.js";

const BEAT = 380; // milliseconds of one step of Gauss-Newton
const STILL = 1e-4;
const MOST_STEPS = 40;
const TURN = Math.PI / 60;

export function begin(bench, { data }) {
  const { button, decimal, list, make } = bench.tools;
  const state = {
    poses: data.poses.map((pose) => [...pose]),
    edges: data.edges.map((edge) => ({ ...edge })),
    glide: null,
    steps: 0,
  };
  let values = bench.settings((now) => {
    values = now;
    tell();
  });

  const handles = state.poses.map((pose, k) =>
    bench.handle({
      label: `Pose ${k}`, at: pose, box: [-1.3, -1.3, 7.8, 6.1], step: 0.1, look: "hand-small",
      told: (x, y) => `x = ${decimal(x, 1)}, y = ${decimal(y, 1)}, cap ${decimal((state.poses[k][2] * 180) / Math.PI, 0)}°`,
      moved: (x, y) => move(k, [x, y, state.poses[k][2]]),
      held: () => stop(),
      key: (event) => pressed(k, event.key),
    }),
  ); // prettier-ignore
  // One of them only is reached with Tab; the others from there.
  handles.forEach(({ element }, k) => {
    element.tabIndex = k === 10 ? 0 : -1;
    element.addEventListener("focus", () => {
      for (const other of handles) other.element.tabIndex = other.element === element ? 0 : -1;
      draw();
    });
    element.addEventListener("blur", () => draw());
  });

  function pressed(k, key) {
    const turn = { g: 1, d: -1 }[key.toLowerCase()];
    const other = { PageUp: k - 1, PageDown: k + 1 }[key];
    if (turn) {
      const [x, y, angle] = state.poses[k];
      move(k, [x, y, Math.atan2(Math.sin(angle + turn * TURN), Math.cos(angle + turn * TURN))]);
      handles[k].put(x, y);
    } else if (other !== undefined) handles[(other + handles.length) % handles.length].element.focus();
    else return false;
    return true;
  }

  function move(k, pose) {
    stop();
    state.steps = 0;
    state.poses[k] = pose;
    if (values.suivre === "1") settle(k);
    tell();
  }

  /** The others follow the hand: one step, with the pose that is held where it is held. */
  function settle(k) {
    state.poses = step(state.edges, state.poses, KERNELS[values.noyau], k === 0 ? [0] : [0, k]);
  }

  function stop() {
    if (state.glide) state.poses = state.glide.to;
    state.glide = null;
  }

  function once() {
    const from = state.poses;
    const to = step(state.edges, from, KERNELS[values.noyau], [0]);
    const furthest = Math.max(...to.map((pose, k) => Math.hypot(pose[0] - from[k][0], pose[1] - from[k][1])));
    state.steps += 1;
    return { from, to, furthest };
  }

  /** One step, or all of them, on their way. */
  function relax(all) {
    stop();
    state.steps = 0;
    const beat = window.matchMedia("(prefers-reduced-motion: reduce)").matches ? 0 : BEAT;
    const next = () => {
      const way = once();
      state.glide = { ...way, begun: performance.now() };
      requestAnimationFrame(function tick(now) {
        if (state.glide?.to !== way.to) return;
        const part = beat ? Math.min(1, Math.max(0, now - state.glide.begun) / beat) : 1;
        state.poses = way.from.map((pose, k) => between(pose, way.to[k], part));
        if (part < 1) {
          tell();
          requestAnimationFrame(tick);
          return;
        }
        state.poses = way.to;
        state.glide = null;
        tell();
        if (all && way.furthest > STILL && state.steps < MOST_STEPS) next();
      });
    };
    next();
  }

  function tell() {
    handles.forEach((handle, k) => handle.holding || handle.put(state.poses[k][0], state.poses[k][1]));
    const chi2 = edgeChi2(state.edges, state.poses);
    const kernel = KERNELS[values.noyau];
    const total = chi2.reduce((sum, one) => sum + one, 0);
    const worst = chi2.indexOf(Math.max(...chi2));
    const { i, j } = state.edges[worst];
    const through = values.noyau === "aucun" ? "" : `, et ${number(cost(state.edges, chi2, kernel))} à travers le noyau`;
    const after = state.steps > 0 ? ` ${state.steps === 1 ? "Un pas" : `${state.steps} pas`} de Gauss-Newton.` : "";
    bench.say(
      `Somme des χ²\u00a0: ${number(total)}${through}.${after}`,
      `Le ressort le plus tendu va de ${i} à ${j}\u00a0: χ²\u00a0=\u00a0${number(chi2[worst])}.`,
    );
    const weigh = weights(state.edges, chi2, kernel);
    for (const [k, row] of rows) {
      row.chi2.textContent = number(chi2[k]);
      row.weight.textContent = weigh[k] >= 0.995 ? "1" : weigh[k] < 0.001 ? "≈\u00a00" : decimal(weigh[k], weigh[k] < 0.1 ? 3 : 2);
    }
    state.chi2 = chi2;
    state.weights = weigh;
    draw();
  }

  function number(value) {
    return value < 100 ? decimal(value, value < 10 ? 2 : 1) : Math.round(value).toLocaleString("fr-FR");
  }

  function draw() {
    if (!state.chi2) return;
    const colours = {};
    const springs = state.edges.map((edge, k) => {
      const level = Math.min(1, Math.log10(1 + state.chi2[k]) / 3);
      const name = `spring${k}`;
      colours[name] = blend(level, bench.colours);
      const ends = [state.poses[edge.i], state.poses[edge.j]];
      const width = (doubted(edge) ? 2.2 : 1.6) + 2.2 * level;
      return { kind: "polyline", color: name, width, dashed: state.weights[k] < 0.5, moved: list(coil(...ends)) };
    });
    const held = handles.findIndex(({ element }) => element === document.activeElement);
    const places = state.poses.map(([x, y]) => [x, y]);
    const named = state.poses.map((_, k) => k).filter((k) => k % 5 === 0 || k === held || k === state.poses.length - 1);
    bench.paint(
      [
        { kind: "polyline", color: "truth", width: 1.2, dashed: true, moved: list(data.truth.map(([x, y]) => [x, y])) },
        ...springs,
        {
          kind: "points", color: "estimate", size: 5, opacity: 1, moved: list(places),
          headings: true, turned: list(state.poses.map((pose) => [pose[2]])),
        },
        { kind: "labels", color: "ink", texts: named.map(String), moved: list(named.map((k) => [places[k][0], places[k][1] + 0.34])) },
      ],
      colours,
    ); // prettier-ignore
  }

  // The closures: cut one, tie another.
  const body = make("tbody");
  const head = ["Fermeture", "χ²", "Poids", ""].map((words) => make("th", { scope: "col" }, words || make("span", { class: "visually-hidden" }, "Action")));
  const table = make("table", { class: "hands-table" }, make("thead", {}, make("tr", {}, ...head)), body);
  let rows = [];

  function listed() {
    const closures = state.edges.map((edge, k) => [k, edge]).filter(([, edge]) => doubted(edge));
    rows = closures.map(([k]) => [k, { chi2: make("td"), weight: make("td") }]);
    body.replaceChildren(
      ...closures.map(([k, { i, j }], n) =>
        make("tr", {}, make("th", { scope: "row" }, `${i} – ${j}`), rows[n][1].chi2, rows[n][1].weight, make("td", {}, cutter(k, i, j))),
      ),
    );
    table.hidden = closures.length === 0;
    tell();
  }

  function cutter(k, i, j) {
    const cut = button("Couper", () => {
      stop();
      state.edges.splice(k, 1);
      state.steps = 0;
      listed();
      tie.focus();
    });
    cut.setAttribute("aria-label", `Couper la fermeture ${i} – ${j}`);
    return cut;
  }

  const chosen = (label, value) => {
    const options = state.poses.map((_, k) => make("option", { value: k, selected: k === value }, String(k)));
    return make("select", { "aria-label": label }, ...options);
  };
  const [from, to] = [chosen("Première pose", 6), chosen("Seconde pose", 16)];
  const refused = make("p", { class: "hands-help", role: "status" });
  const tie = button("Nouer", () => {
    const [i, j] = [Number(from.value), Number(to.value)].sort((a, b) => a - b);
    const known = state.edges.some((edge) => edge.i === i && edge.j === j);
    refused.textContent = j - i < 2 || known ? "Choisissez deux poses qui ne se suivent pas, et qu’aucun ressort ne joint encore." : "";
    if (refused.textContent) return;
    stop();
    state.edges.push({ i, j, z: [0, 0, 0], information: data.closure });
    state.steps = 0;
    listed();
  });
  const again = () => {
    stop();
    state.poses = data.poses.map((pose) => [...pose]);
    state.edges = data.edges.map((edge) => ({ ...edge }));
    state.steps = 0;
    listed();
  };

  bench.side.prepend(
    make(
      "div", { class: "hands-buttons" },
      button("Détendre", () => relax(true), "button primary"),
      button("Un pas", () => relax(false)),
      button("Tout remettre", again),
    ),
  ); // prettier-ignore
  bench.side.append(
    table,
    make("div", { class: "hands-tie" }, "Affirmer que les poses ", from, " et ", to, " sont au même endroit\u00a0: ", tie),
    refused,
    make(
      "p", { class: "hands-help" },
      "Tirez une pose, ou prenez-la avec Tab puis les flèches (Maj\u00a0: plus vite)\u00a0; ",
      make("kbd", {}, "G"), " et ", make("kbd", {}, "D"), " la tournent, ",
      make("kbd", {}, "Page ↑"), " et ", make("kbd", {}, "Page ↓"), " passent à une autre. La pose 0 est fixée\u00a0: elle ne bouge que sous votre main.",
    ),
  ); // prettier-ignore
  listed();
}

/** A coil from one place to another. */
function coil([x0, y0], [x1, y1]) {
  const [dx, dy] = [x1 - x0, y1 - y0];
  const length = Math.hypot(dx, dy);
  if (length < 1e-6) return [[x0, y0], [x1, y1]];
  const [nx, ny] = [(-0.09 * dy) / length, (0.09 * dx) / length];
  const teeth = Math.max(6, 2 * Math.round(3 * length));
  const points = [[x0, y0]];
  for (let k = 0; k <= teeth; k += 1) {
    const part = 0.2 + (0.6 * k) / teeth;
    const side = k === 0 || k === teeth ? 0 : k % 2 ? 1 : -1;
    points.push([x0 + part * dx + side * nx, y0 + part * dy + side * ny]);
  }
  return [...points, [x1, y1]];
}

/** From green, through orange, to red. */
function blend(level, { measure, estimate, alert }) {
  const [from, to, part] = level < 0.5 ? [measure, estimate, 2 * level] : [estimate, alert, 2 * level - 1];
  return from.map((value, k) => Math.round(value + part * (to[k] - value)));
}

function between(from, to, part) {
  const angle = Math.atan2(Math.sin(to[2] - from[2]), Math.cos(to[2] - from[2]));
  return [from[0] + part * (to[0] - from[0]), from[1] + part * (to[1] - from[1]), from[2] + part * angle];
}
