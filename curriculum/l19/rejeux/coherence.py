"""Cinquante chariots, deux filtres : celui qui connaît les bruits, et celui que l'on règle. Lequel dit vrai ?"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from graders.scene.replay import (
    Chart,
    Color,
    Draw,
    Frame,
    Key,
    Layer,
    Level,
    Points,
    Polyline,
    Prediction,
    Replay,
    Segments,
    Series,
    Slider,
    Values,
    View,
    decimal,
)
from reference.filters.scalar import ScalarBelief, mean_nees_band

Floats = NDArray[np.float64]

TITLE = "Cinquante chariots : le filtre dit-il vrai ?"
ALT = (
    "Deux dessins côte à côte. Sur chacun, pas après pas, les erreurs de cinquante chariots, en points, et deux "
    "lignes : deux écarts-types au-dessus et au-dessous de zéro, tels que le filtre les annonce. À gauche, le filtre "
    "connaît les vrais bruits, et presque tous les points sont entre les lignes. À droite, il se croit plus précis "
    "qu'il n'est : les lignes se resserrent, et beaucoup de points sont dehors, en rouge. Dessous, le NEES moyen des "
    "deux filtres, et la bande où celui d'un filtre honnête reste dix-neuf fois sur vingt."
)
PARAMETERS = {
    "pas": Slider("Bruit de pas supposé, le vrai étant 1", 0.1, 3.0, 0.1, 0.3),
    "mesure": Slider("Bruit de mesure supposé, le vrai étant 1", 0.1, 3.0, 0.1, 1.0),
    "pente": Slider("Glissement que le filtre ignore, par pas", 0.0, 0.2, 0.02, 0.0, "m"),
    "tirage": Draw(default=0),
}
PREDICTION = Prediction(
    "À droite, le filtre croit ses pas trois fois plus précis qu'ils ne sont. Cinquante chariots roulent. Que "
    "verra-t-on ?",
    (
        ("sur", "Des erreurs plus grandes qu'à gauche, et un filtre qui s'annonce pourtant plus précis."),
        ("mieux", "Des erreurs plus petites : le filtre est plus précis."),
        ("pareil", "Les mêmes erreurs : les mesures corrigent tout."),
        ("timide", "Un filtre qui s'annonce moins précis qu'il n'est."),
    ),
    right="sur",
    why=(
        "Il annonce 0,17 m au lieu de 0,29 : son gain tombe de 0,33 à 0,11, et il n'écoute presque plus le télémètre. "
        "Ses erreurs, elles, montent de 0,28 à 0,39 m. Son NEES moyen vaut 5,18 : c'est à cela qu'on le prend."
    ),
)
RUNS, STEPS, STEP, NOISE, START = 50, 40, 0.2, 0.5, 0.5
HALF = 1.5
WIDTH = 5.0
SETTLED = 10


@dataclass(frozen=True, eq=False)
class Told:
    """Ce qu'un filtre répond : à chaque pas, les erreurs des chariots (pas + 1, chariots) et son écart-type."""

    errors: Floats
    sigmas: Floats
    gain: float

    @property
    def nees(self) -> Floats:
        """(pas + 1, chariots)."""
        return np.asarray((self.errors / self.sigmas[:, None]) ** 2)

    @property
    def out(self) -> NDArray[np.bool_]:
        return self.nees > 4.0

    @property
    def rms(self) -> float:
        """L'erreur quadratique moyenne, une fois le filtre posé."""
        return float(np.sqrt(np.mean(self.errors[SETTLED:] ** 2)))

    @property
    def mean_nees(self) -> float:
        return float(self.nees[SETTLED:].mean())


def compute(values: Values, rng: np.random.Generator) -> Replay:
    slope = values.number("pente")
    truth, read = drawn(rng, slope)
    honest = follow(truth, read, STEP, NOISE, slope)
    tuned = follow(truth, read, STEP * values.number("pas"), NOISE * values.number("mesure"))
    filters = (honest, tuned)
    frames = [frame(filters, step) for step in range(STEPS + 1)]
    return Replay(
        View(-0.2, -HALF - 0.1, WIDTH + 0.2, HALF + 0.1, up=True),
        frames,
        summary(filters),
        layers=[Segments([[0.0, 0.0]], [[WIDTH, 0.0]], "faint", width=1.0), *clouds(filters)],
        charts=[chart(filters)],
        legend=[
            Key("dot", "truth", "l'erreur d'un chariot, entre les lignes"),
            Key("dot", "alert", "celle d'un chariot hors des lignes"),
            Key("line", "estimate", "deux écarts-types annoncés"),
        ],
        period=0.35,
        panels=["bien réglé", "réglé par vous"],
    )


def drawn(rng: np.random.Generator, slope: float) -> tuple[Floats, Floats]:
    """Les places des chariots à chaque pas (pas + 1, chariots), de moyenne nulle, et ce que lit le télémètre."""
    start = START * rng.standard_normal((1, RUNS))
    steps = slope + STEP * rng.standard_normal((STEPS, RUNS))
    truth = np.concatenate([start, steps]).cumsum(axis=0)
    return truth, truth + NOISE * rng.standard_normal(truth.shape)


def follow(truth: Floats, read: Floats, step: float, noise: float, slope: float = 0.0) -> Told:
    """Un filtre qui suppose ces bruits, et ce glissement."""
    belief = ScalarBelief(np.zeros(RUNS), START**2)
    errors, sigmas, gain = [belief.mean - truth[0]], [belief.sigma], 0.0
    for place, z in zip(truth[1:], read[1:], strict=True):
        belief = belief.predict(slope, step**2).correct(z, noise**2)
        gain = belief.variance / noise**2
        errors.append(belief.mean - place)
        sigmas.append(belief.sigma)
    return Told(np.array(errors), np.array(sigmas), gain)


def clouds(filters: Sequence[Told]) -> list[Layer]:
    """Les erreurs, qui paraissent pas après pas, et les deux lignes de chaque filtre."""
    across = np.linspace(0.0, WIDTH, STEPS + 1)
    shown: list[Layer] = []
    for panel, told in enumerate(filters):
        at = np.column_stack([np.repeat(across, RUNS), np.clip(told.errors.ravel(), -HALF, HALF)])
        inside: tuple[Color, NDArray[np.bool_], float] = ("truth", ~told.out, 1.4)
        outside: tuple[Color, NDArray[np.bool_], float] = ("alert", told.out, 2.0)
        for color, kept, size in (inside, outside):
            until = np.cumsum(kept.sum(axis=1)).tolist()
            shown.append(Points(at[kept.ravel()], color, size, opacity=0.7, panel=panel, until=until))
        for side in (-2.0, 2.0):
            line = np.column_stack([across, np.clip(side * told.sigmas, -HALF, HALF)])
            shown.append(Polyline(line, "estimate", 2.5, panel=panel))
    return shown


def frame(filters: Sequence[Told], step: int) -> Frame:
    here = WIDTH * step / STEPS
    left, right = (int(told.out[step].sum()) for told in filters)
    return Frame(
        [Segments([[here, -HALF]], [[here, HALF]], "ink", width=1.0, dashed=True)],
        f"Pas {step}. Hors des lignes : {left} des {RUNS} chariots à gauche, {right} à droite ; un filtre honnête en "
        f"laisse 2 ou 3. Écart-type annoncé : {decimal(float(filters[0].sigmas[step]), 2)} m à gauche, "
        f"{decimal(float(filters[1].sigmas[step]), 2)} m à droite.",
        step,
    )


def chart(filters: Sequence[Told]) -> Chart:
    low, high = mean_nees_band(RUNS)
    return Chart(
        f"Le NEES, moyen sur les {RUNS} chariots",
        [
            Series("bien réglé", "truth", filters[0].nees.mean(axis=1)),
            Series("réglé par vous", "alert", filters[1].nees.mean(axis=1)),
        ],
        "pas",
        (0.0, None),
        levels=[
            Level(low, "", "second"),
            Level(high, f"bande d'un filtre honnête : {decimal(low, 2)} à {decimal(high, 2)}", "second"),
        ],
    )


def summary(filters: Sequence[Told]) -> list[str]:
    low, high = mean_nees_band(RUNS)
    honest, tuned = filters
    texts = [
        f"Une fois posé, le filtre bien réglé annonce {decimal(float(honest.sigmas[-1]), 2)} m, avec un gain "
        f"de {decimal(honest.gain, 2)} ; l'erreur quadratique moyenne est de {decimal(honest.rms, 2)} m, et le NEES "
        f"moyen vaut {decimal(honest.mean_nees, 2)}.",
        f"Le vôtre annonce {decimal(float(tuned.sigmas[-1]), 2)} m, avec un gain de {decimal(tuned.gain, 2)} ; son "
        f"erreur est de {decimal(tuned.rms, 2)} m, et son NEES moyen vaut {decimal(tuned.mean_nees, 2)}.",
    ]
    means = tuned.nees[SETTLED:].mean(axis=1)
    above, below = int(np.sum(means > high)), int(np.sum(means < low))
    rare = len(means) // 5
    verdict = (
        "Il est trop sûr de lui."
        if above > rare
        else "Il doute trop."
        if below > rare
        else "Rien ne le distingue d'un filtre bien réglé."
    )
    texts.append(
        f"Des {len(means)} derniers pas, le NEES moyen du vôtre est au-dessus de la bande à {above}, au-dessous à "
        f"{below}. {verdict}"
    )
    return texts
