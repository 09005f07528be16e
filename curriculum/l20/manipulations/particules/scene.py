"""Poser soi-même les particules, puis lancer le filtre."""

from __future__ import annotations

import numpy as np

from curriculum.l20.manipulations._filtre import film
from curriculum.l20.rejeux._carte import carte, murs, pluriel, plus_proche_libre
from curriculum.l20.rejeux.mcl import routes
from graders.scene.hands import Spots, Start, spots_of
from graders.scene.replay import Choice, Draw, Key, Replay, Slider, Switch, Values, View

TITLE = "Placez vous-même les particules"
ALT = (
    "Le plan du module, vu de dessus. Un robot bleu attend dans une pièce à gauche. Chaque endroit que l'on touche "
    "reçoit une poignée de particules orange, ou un nuage entier, que de petits traits orientent. Le filtre part "
    "ensuite de ces particules-là, et l'on voit s'il retrouve le robot."
)
HEIGHT, WIDTH = carte().shape
PARAMETERS = {
    "touche": Choice("Chaque toucher pose", (("5", "une poignée : 5"), ("100", "un nuage : 100")), "100"),
    "cap": Switch("Particules tournées comme le robot"),
    "injection": Slider("Particules injectées", 0, 20, 1, 0, "%"),
    "endroits": Spots("Endroits", (0.0, 0.0, WIDTH, HEIGHT), most=24, total=1200),
    "tirage": Draw("Un autre tirage", default=1),
}
STEPS, SPREAD, TURNED = 24, {5: 0.25, 100: 0.8}, 0.2


def compute(values: Values, rng: np.random.Generator) -> Start | Replay:
    spots, path = spots_of(values.choice("endroits")), routes()[0][: STEPS + 1]
    if not spots:
        data = {"walls": murs().wire(), "robot": path[0].tolist(), "most": 24, "total": 1200, "spread": SPREAD}
        keys = [Key("robot", "truth", "vrai robot"), Key("dot", "estimate", "endroit touché")]
        return Start(View(0, 0, WIDTH, HEIGHT), data, keys)
    placed = np.vstack([around(x, y, count, rng) for x, y, count in spots])
    headings = rng.uniform(-np.pi, np.pi, len(placed))
    if values.flag("cap"):
        headings = path[0, 2] + rng.normal(0.0, TURNED, len(placed))
    begun = f"Au départ : vos {len(placed)} particules, en {pluriel(len(spots), 'endroit', 'endroits')}."
    return film(carte(), path, np.column_stack([placed, headings]), values.whole("injection") / 100.0, rng, begun)


def around(x: float, y: float, count: int, rng: np.random.Generator) -> np.ndarray:
    """`count` points libres (count, 2) près de (x, y)."""
    drawn = rng.normal([x, y], SPREAD[5 if count <= 5 else 100], (count, 2))
    for k in np.flatnonzero(~carte().is_free(drawn)):
        drawn[k] = plus_proche_libre(*drawn[k])
    return drawn
