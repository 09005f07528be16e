// The reader touches the map where the robot may be; the filter then starts from there, computed by the server.

const REST = 250; // milliseconds without another change, after which the filter runs anew

export function begin(bench, { data, box }) {
  const { button, decimal, list, make } = bench.tools;
  const [x0, y0, x1, y1] = box;
  let spots = []; // [x, y, count]
  let waiting = 0;
  let values = bench.settings((now) => {
    const touch = now.touche !== values.touche; // says what comes next, and changes nothing of what was placed
    values = now;
    if (!bench.film) tell();
    else if (!touch) {
      clearTimeout(waiting);
      waiting = setTimeout(run, REST);
    }
  });
  const wall = { ...data.walls };
  const status = make("p", { class: "hands-help", role: "status" });
  const total = () => spots.reduce((sum, [, , count]) => sum + count, 0);

  const hand = bench.handle({
    label: "Où poser des particules", at: [(x0 + x1) / 2, (y0 + y1) / 2], box: [x0 + 1, y0 + 1, x1 - 1, y1 - 1], step: 0.5, look: "hand-cell",
    moved: () => draw(),
    key: ({ key }) => {
      if (key === "Enter" || key === " ") put(...hand.at);
      else if (key === "Backspace" || key === "Delete") back();
      else return false;
      return true;
    },
  }); // prettier-ignore
  bench.place.classList.add("hands-touch");
  hand.element.addEventListener("focus", () => draw());
  hand.element.addEventListener("blur", () => draw());
  bench.canvas.addEventListener("click", (event) => {
    if (bench.film) return;
    const page = bench.canvas.getBoundingClientRect();
    const [x, y] = bench.stage.paper.back(event.clientX - page.left, event.clientY - page.top);
    if (x > x0 && x < x1 && y > y0 && y < y1) put(x, y);
  });

  function put(x, y) {
    const count = Number(values.touche);
    if (spots.length >= data.most || total() + count > data.total) {
      status.textContent = `C’est assez\u00a0: ${data.most} endroits et ${data.total} particules au plus.`;
      return;
    }
    status.textContent = "";
    spots.push([Number(x.toFixed(2)), Number(y.toFixed(2)), count]);
    hand.put(x, y);
    tell();
  }

  function back() {
    spots.pop();
    status.textContent = "";
    tell();
  }

  function run() {
    if (spots.length === 0) {
      status.textContent = "Touchez d’abord le plan\u00a0: il n’y a encore aucune particule.";
      return;
    }
    const endroits = spots.map((spot) => spot.join(",")).join(";");
    bench.run({ cap: values.cap, injection: values.injection, tirage: values.tirage, endroits }, status);
  }

  const start = button("Lancer le filtre", run, "button primary");
  const before = make(
    "div", { class: "hands-buttons hands-before" },
    start,
    button("Ôter le dernier", back),
    button("Tout ôter", () => {
      spots = [];
      tell();
    }),
  ); // prettier-ignore
  const after = make("div", { class: "hands-buttons hands-after" }, button("Replacer les particules", () => (bench.stop(), tell(), start.focus())));
  const help = "Touchez le plan, ou prenez la croix avec Tab\u00a0: les flèches la déplacent, Entrée pose, Effacement ôte.";
  bench.side.prepend(before, after, status);
  bench.side.append(make("p", { class: "hands-help hands-before" }, help));

  function tell() {
    const heads = values.cap === "1" ? "tournées comme le robot" : "aux caps tirés au sort";
    const where = spots.length === 1 ? "un endroit" : `${spots.length} endroits`;
    bench.say(
      spots.length === 0
        ? "Où le robot peut-il être\u00a0? Touchez le plan pour y poser des particules."
        : `${total()} particules en ${where}, ${heads}. Le dernier\u00a0: x\u00a0=\u00a0${decimal(spots.at(-1)[0], 1)}, y\u00a0=\u00a0${decimal(spots.at(-1)[1], 1)}.`,
    );
    draw();
  }

  function draw() {
    const layers = [wall];
    for (const [x, y, count] of spots) {
      layers.push({ kind: "circles", color: "estimate", radius: 1.5 * data.spread[count], filled: true, moved: list([[x, y]]) });
    }
    layers.push({ kind: "points", color: "estimate", size: 2.6, opacity: 1, moved: list(spots.flatMap(scattered)) });
    layers.push({ kind: "pose", color: "truth", radius: 0.4, style: "robot", at: data.robot });
    if (hand.element === document.activeElement) {
      const [x, y] = hand.at;
      layers.push({ kind: "segments", color: "ink", width: 2, opacity: 1, moved: list([[x - 0.5, y, x + 0.5, y], [x, y - 0.5, x, y + 0.5]]) });
    }
    bench.paint(layers);
  }

  /** A picture of so many points around a place: the server draws the true ones. */
  function scattered([x, y, count]) {
    const shown = Math.min(count, 40);
    return Array.from({ length: shown }, (_, k) => {
      const [radius, angle] = [data.spread[count] * 1.3 * Math.sqrt((k + 0.5) / shown), 2.399963 * k];
      return [x + radius * Math.cos(angle), y + radius * Math.sin(angle)];
    });
  }

  tell();
}
