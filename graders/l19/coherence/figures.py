"""Figures of l19/coherence: an error beside the ellipse of its doubt, the band of a mean, the NEES of every run."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from scipy.special import gammaln

from graders.core.compare.told_apart import number_text_pair
from graders.l19.coherence.pictures import BAND, ERROR, RUNS
from graders.l19.ellipses import draw_belief
from graders.plotting import EXPECTED, OBTAINED, THIRD, ink_of


def draw_error(figure: Figure, data: dict[str, Any]) -> None:
    """Ellipses of one, two and three deviations: the NEES is the square of the one that the truth stands on."""
    axes = figure.add_subplot()
    centre, P = np.asarray(data["estimated"], dtype=float), np.asarray(data["P"], dtype=float)
    for k in (1, 2, 3):
        draw_belief(axes, (centre, k * k * P), ink_of(axes), "1, 2 et 3 écarts-types" if k == 1 else "_", style="--")
    wanted, obtained = number_text_pair(data["expected"], 0.0 if data["got"] is None else data["got"], 4)
    draw_belief(axes, (centre, data["expected"] * P), EXPECTED, f"NEES attendu : {wanted}", width=3)
    if data["got"] is not None and 0.0 < data["got"] < 100.0 * max(data["expected"], 1.0):
        draw_belief(axes, (centre, data["got"] * P), OBTAINED, f"NEES obtenu : {obtained}")
    axes.plot(*data["true"], "*", color=THIRD, ms=14, label="vraie position")
    axes.set_aspect("equal", adjustable="datalim")
    axes.set(xlabel="première composante", ylabel="seconde composante", title="Sur quelle ellipse la vérité est-elle ?")
    figure.legend(loc="outside lower center", ncols=2)


def draw_band(figure: Figure, data: dict[str, Any]) -> None:
    """The law of the mean, and its ends."""
    axes = figure.add_subplot()
    n, N, (low, high) = data["n"], data["N"], data["expected"]
    places = np.linspace(max(1e-3, 0.3 * low), 1.6 * high, 400)
    half = 0.5 * n * N
    heights = 0.5 * N * np.exp((half - 1.0) * np.log(0.5 * N * places) - 0.5 * N * places - gammaln(half))
    inside = (places >= low) & (places <= high)
    axes.plot(places, heights, color=ink_of(axes), lw=1.8, label="loi du NEES moyen")
    axes.fill_between(places[inside], heights[inside], color=EXPECTED, alpha=0.25, label="bande attendue", lw=0)
    for k, end in enumerate(data["got"] or []):
        axes.axvline(end, color=OBTAINED, lw=2.0, label="bouts obtenus" if k == 0 else "_")
    axes.set_ylim(0.0, 1.1 * float(np.max(heights[inside], initial=0.1)))
    axes.set(xlabel="NEES moyen", ylabel="densité", title=f"{_runs(N)} de dimension {n}, à {100 * data['level']:.0f} %")
    figure.legend(loc="outside lower center", ncols=3)


def draw_runs(figure: Figure, data: dict[str, Any]) -> None:
    """The NEES of every run, and where their mean falls."""
    axes = figure.add_subplot()
    values, (low, high) = data["values"], data["band"]
    axes.axhspan(low, high, color=EXPECTED, alpha=0.2, lw=0, label="bande de la moyenne")
    axes.plot(np.arange(1, len(values) + 1), values, "o", color=ink_of(axes), ms=4, label="NEES d'un essai")
    axes.axhline(data["mean"], color=EXPECTED, lw=2.4, label="moyenne attendue")
    if data["got"] is not None:
        axes.axhline(data["got"], color=OBTAINED, lw=1.6, ls="--", label="moyenne obtenue")
    axes.set_ylim(min(0.0, data["got"] or 0.0), 1.1 * max(*values, high, data["mean"], data["got"] or 0.0))
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.set(xlabel="essai n°", ylabel="NEES", title="La moyenne tombe-t-elle dans la bande ?")
    figure.legend(loc="outside lower center", ncols=2)


def _runs(count: int) -> str:
    return f"{count} essais" if count > 1 else "1 essai"


FIGURES = {
    ERROR: (
        draw_error,
        "Plan des deux composantes de l’état : la vraie position (étoile verte) et les ellipses à 1, 2 et 3 "
        "écarts-types de l’estimation (tirets). L’ellipse bleue, de NEES attendu, passe par l’étoile ; l’ellipse "
        "orange est celle du NEES que donne votre programme.",
    ),
    BAND: (
        draw_band,
        "Densité de probabilité du NEES moyen, en abscisse. La zone bleue sous la courbe est la bande attendue ; "
        "les deux traits verticaux orange sont les bornes que donne votre programme : ils devraient limiter cette "
        "zone.",
    ),
    RUNS: (
        draw_runs,
        "NEES de chaque essai, un point par essai, avec la bande de la moyenne en bleu pâle. Le trait bleu est la "
        "moyenne attendue, le trait orange en tirets celle de votre programme : les deux devraient se confondre.",
    ),
}
