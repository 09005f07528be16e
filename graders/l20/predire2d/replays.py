"""Replays of l20/predire2d: what the student's filter believed at each step of a walk, beside the reference."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from graders.core.contract.values import Floats
from graders.l20.predire2d.cases import module_world
from graders.l20.predire2d.trials import NEAR, SIGMA, gap
from graders.scene.replay import (
    Chart,
    Circles,
    Frame,
    Grid,
    Key,
    Layer,
    Mark,
    Pose,
    Rays,
    Replay,
    Series,
    View,
    decimal,
)
from graders.typography import elided
from reference.localisation.grid_filter import Cell, GridWorld, correct, most_likely_cell, predict

#: Beliefs that differ by this share of their mass are no longer the same; the bytes of a film make less than a quarter
#: of it.
APART = 0.02
ALT = (
    "Deux plans quadrillés du même bâtiment, vus de dessus : à gauche ou en haut votre croyance, à côté celle de la "
    "référence, après les mêmes ordres et les mêmes scans. Chaque case est d'autant plus colorée que le filtre croit y "
    "voir le robot ; un disque bleu montre où il est vraiment, un cercle orange la case la plus probable. Dessous, une "
    "courbe suit la probabilité que chacune des deux donne à la vraie case."
)
WORDS = {(1, 0): "à droite", (-1, 0): "à gauche", (0, 1): "en bas", (0, -1): "en haut"}
YOURS, THEIRS = 0, 1


@dataclass(frozen=True)
class Moment:
    """A prediction or a correction: what was done, where the robot is, and both beliefs after it (None: no more)."""

    function: str
    text: str
    cell: Cell
    scan: Floats | None
    wanted: Floats
    got: Floats | None

    @property
    def apart(self) -> float:
        """The share of the mass that is elsewhere."""
        return 0.0 if self.got is None else float(np.abs(self.got - self.wanted).sum()) / 2.0


def localisation(data: dict[str, Any]) -> Replay:
    """The film of one walk (`trials.film`), beside what the reference believes on it."""
    grid = module_world()
    start: Cell = (data["start"][0], data["start"][1])
    moments = _moments(grid, data)
    height, width = grid.free.shape
    wrong = next((k for k, moment in enumerate(moments, 1) if moment.apart > APART or moment.got is None), None)
    first = Frame(
        [*_beside(grid.uniform_belief(), grid.uniform_belief()), _robot(start)],
        "Au départ, le filtre ne sait rien : toutes les cases libres se valent.",
    )
    return Replay(
        View(0, 0, width, height),
        [first, *(_frame(moment, wrong == k) for k, moment in enumerate(moments, 1))],
        _summary(moments, wrong),
        layers=[Grid(~grid.free, "walls")],
        charts=[_chart(grid, start, moments, wrong)],
        legend=[
            Key("cell", "estimate", "croyance"),
            Key("ring", "estimate", "case la plus probable"),
            Key("robot", "truth", "où le robot est vraiment"),
            Key("line", "measure", "les quatre rayons du scan"),
        ],
        period=0.9,
        alt=ALT,
        panels=("Votre croyance", "Celle de la référence"),
        wrong=wrong,
    )


def _moments(grid: GridWorld, data: dict[str, Any]) -> list[Moment]:
    """As far as the student's beliefs go, and one more where they stop before the end."""
    got = [_normalised(_levels(belief).reshape(grid.free.shape)) for belief in data["beliefs"]]
    wanted, moments = grid.uniform_belief(), []
    for step, ((du, dv), (y, x)) in enumerate(zip(data["commands"], data["cells"], strict=True), 1):
        wanted = predict(grid, wanted, du, dv)
        asked = f"on demande une case {WORDS[du, dv]}"
        moments.append(("predire2d", f"Pas {step}, predire2d : {asked}.", (y, x), None, wanted))
        scan = grid.scans[y, x]
        wanted = correct(grid, wanted, scan, SIGMA)
        read = " ; ".join(decimal(float(distance)) for distance in scan)
        moments.append(("corriger2d", f"Pas {step}, corriger2d : le scan lit {read}.", (y, x), scan, wanted))
    shown = moments[: len(got) + 1]
    return [Moment(*told, got[k] if k < len(got) else None) for k, told in enumerate(shown)]


def _levels(text: str) -> Floats:
    return np.frombuffer(bytes.fromhex(text), dtype=np.uint8).astype(np.float64)


def _normalised(levels: Floats) -> Floats:
    """The belief that a film's bytes show; all zeros where the program left nothing."""
    belief = (levels / 255.0) ** 2
    total = float(belief.sum())
    return np.asarray(belief / total if total > 0.0 else belief)


def _beside(got: Floats | None, wanted: Floats) -> list[Layer]:
    layers: list[Layer] = []
    for panel, belief in ((YOURS, got), (THEIRS, wanted)):
        if belief is None or belief.max() <= 0.0:
            continue
        layers.append(Grid(np.sqrt(belief), "belief", panel=panel))
        if belief.max() > 1.5 / np.count_nonzero(module_world().free):
            y, x = most_likely_cell(belief)
            layers.append(Circles([[x + 0.5, y + 0.5]], 0.5, "estimate", filled=False, panel=panel))
    return layers


def _robot(cell: Cell) -> Pose:
    return Pose([cell[1] + 0.5, cell[0] + 0.5, 0.0], "truth")


def _frame(moment: Moment, wrong: bool) -> Frame:
    layers = [*_beside(moment.got, moment.wanted), _robot(moment.cell)]
    if moment.scan is not None:
        centre = np.array([moment.cell[1] + 0.5, moment.cell[0] + 0.5])
        ways = np.array([[1, 0], [0, 1], [-1, 0], [0, -1]])
        layers.append(Rays(centre, centre + moment.scan[:, None] * ways))
    text = moment.text
    if moment.got is None:
        text += f" Ici {moment.function} n'a pas renvoyé de croyance."
    elif moment.got.max() <= 0.0:
        text += " Votre croyance est nulle partout."
    elif wrong:
        text += f" C'est ici que votre croyance s'écarte de la référence : regardez {moment.function}."
    elif moment.apart > APART:
        text += f" Les deux croyances diffèrent de {_percent(moment.apart)}."
    return Frame(layers, text)


def _percent(share: float) -> str:
    return f"{round(100.0 * share)} %"


def _chart(grid: GridWorld, start: Cell, moments: Sequence[Moment], wrong: int | None) -> Chart:
    times = np.array([0.0, *(k / 2 for k in range(1, len(moments) + 1))])
    begin = float(grid.uniform_belief()[start])
    yours = [begin, *(float("nan") if one.got is None else float(one.got[one.cell]) for one in moments)]
    return Chart(
        "La probabilité donnée à la vraie case",
        [
            Series(
                "la référence", "truth", [begin, *(float(one.wanted[one.cell]) for one in moments)], times, "dashed"
            ),
            Series("votre code", "estimate", yours, times),
        ],
        "pas (prédiction, puis correction)",
        (0.0, 1.0),
        marks=[] if wrong is None else [Mark(times[wrong], "ça s'écarte ici")],
        cursor=times.tolist(),
    )


def _summary(moments: Sequence[Moment], wrong: int | None) -> list[str]:
    last = moments[-1]
    end = "Votre croyance suit la référence de près, d'un bout à l'autre."
    if wrong is not None:
        step, function = (wrong + 1) // 2, moments[wrong - 1].function
        if moments[wrong - 1].got is None:
            end = f"Votre programme s'arrête au pas {step} : {function} n'y renvoie pas de croyance."
        elif wrong == 1:
            end = f"Votre croyance s'écarte de la référence dès le premier appel {elided('de', function)}."
        else:
            end = f"Votre croyance suit la référence, puis s'en écarte au pas {step}, après {function}."
    if last.got is None or last.got.max() <= 0.0:
        return [end]
    away = gap(most_likely_cell(last.got), last.cell)
    if away == 0:
        return [end, "À la fin, la case la plus probable est celle du robot."]
    place = "à une case" if away == 1 else f"à {away} cases"
    kept = "c'est assez près" if away <= NEAR else "le robot est perdu"
    return [end, f"À la fin, la case la plus probable est {place} du robot : {kept}."]


REPLAYS = {"localisation": localisation}
