"""Figures of l20/modele_faisceau: the density of a reading, what each beam adds, maps of distances."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import Colormap, LinearSegmentedColormap, ListedColormap
from matplotlib.figure import Figure

from graders.core.contract.values import Floats
from graders.plotting import EXPECTED, OBTAINED, THIRD, ink_of
from reference.sensors.beam import plain_log_likelihood

FEW_COLUMNS = 10
#: An answer beyond which the density would be a flat line beside it.
FARTHEST = 40.0


def draw_beam(figure: Figure, data: dict[str, Any]) -> None:
    """One reading: the whole density, the height that is right there, and the one that was found."""
    z, truth, z_max = float(data["z"][0]), float(data["truth"][0]), float(data["z_max"])
    axes = figure.add_subplot()
    at = np.sort(np.append(np.linspace(0.0, z_max * 0.999, 400), [truth - 1e-6, truth]))
    settings = (float(data["sigma"]), z_max, np.array(data["alpha"]), float(data["lam"]))
    curve = [plain_log_likelihood([one], [truth], *settings) for one in np.clip(at, 0.0, None)]
    axes.plot(at, curve, color=ink_of(axes), lw=1.4, label="ln p de toute lecture")
    axes.axvline(truth, color=THIRD, lw=1.0, ls=":", label="distance attendue ẑ")
    axes.plot([z], [data["expected"]], "o", color=EXPECTED, ms=9, label="attendu, en z")
    got = data["got"]
    if got is not None and abs(got) < FARTHEST:
        axes.plot([z], [got], "X", color=OBTAINED, ms=10, label="obtenu, en z")
    axes.set_xlabel("lecture z (cases)")
    axes.set_ylabel("ln p(z | ẑ)")
    axes.set_title("Ce que pèse une lecture")
    figure.legend(loc="outside lower center", ncols=2)


def draw_beams(figure: Figure, data: dict[str, Any]) -> None:
    """Several beams: what each adds to the sum, above the sums themselves."""
    figure.set_size_inches(6.4, 4.2)
    upper, lower = figure.subplots(2, 1, height_ratios=[3, 1])
    each = np.array(data["each"], dtype=float)
    upper.vlines(range(len(each)), 0.0, each, color=EXPECTED, lw=max(0.6, min(4.0, 160.0 / len(each))))
    upper.axhline(0.0, color=ink_of(upper), lw=0.8)
    upper.set_xlabel("rayon k")
    upper.set_ylabel("ln p(zₖ)")
    upper.set_title("Ce que chaque rayon ajoute")
    got = data["got"]
    values = [("attendue", data["expected"], EXPECTED)] + ([] if got is None else [("obtenue", got, OBTAINED)])
    lower.barh([name for name, _, _ in values], [value for _, value, _ in values], color=[c for _, _, c in values])
    lower.axvline(0.0, color=ink_of(lower), lw=0.8)
    lower.invert_yaxis()
    lower.set_xlabel("somme" if got is not None else "somme ; rien à dessiner de ce qui est obtenu")


def draw_field(figure: Figure, data: dict[str, Any]) -> None:
    """The map of distances expected, the one obtained, and where they differ."""
    free, expected = np.array(data["free"], dtype=bool), np.array(data["expected"], dtype=float)
    got = None if data["got"] is None else np.array(data["got"], dtype=float)
    figure.set_size_inches(7.6, 2.7)
    left, middle, right = figure.subplots(1, 3)
    top = max(1.0, float(expected.max()))
    _panel(left, free, expected, "Attendu", _ramp(left, EXPECTED), (0.0, top))
    if got is None:
        for axes, title in ((middle, "Obtenu"), (right, "Différence")):
            _panel(axes, free, np.zeros_like(expected), f"{title} : rien à dessiner", _ramp(axes, OBTAINED), (0.0, 1.0))
        return
    _panel(middle, free, got, "Obtenu", _ramp(middle, OBTAINED), (0.0, top))
    gap = got - expected
    reach = max(1e-9, float(np.abs(gap).max()))
    both = LinearSegmentedColormap.from_list("gap", [EXPECTED, right.get_facecolor(), OBTAINED])
    _panel(right, free, gap, "Obtenu \N{MINUS SIGN} attendu", both, (-reach, reach))


def _ramp(axes: Axes, colour: str) -> Colormap:
    return LinearSegmentedColormap.from_list(colour, [axes.get_facecolor(), colour])


def _panel(
    axes: Axes, free: np.ndarray[Any, Any], values: Floats, title: str, ramp: Colormap, limits: tuple[float, float]
) -> None:
    """Row 0 at the top; walls are framed, since they have a value too."""
    height, width = free.shape
    axes.imshow(values, cmap=ramp, vmin=limits[0], vmax=limits[1], interpolation="nearest", zorder=1)
    walls = np.ma.masked_where(free, np.ones(free.shape))
    axes.imshow(walls, cmap=ListedColormap([ink_of(axes)]), alpha=0.3, interpolation="nearest", zorder=2)
    axes.set_xticks(range(0, width, 1 if width <= FEW_COLUMNS else 2))
    axes.set_yticks(range(0, height, 1 if height <= FEW_COLUMNS else 2))
    axes.tick_params(length=2, labelsize=7)
    axes.grid(False)
    axes.set_title(title, fontsize=10)
    for side in ("top", "right", "left", "bottom"):
        axes.spines[side].set_visible(True)
    if width <= FEW_COLUMNS:
        for (y, x), value in np.ndenumerate(values):
            text = f"{value:.2f}".rstrip("0").rstrip(".").replace(".", ",").replace("-", "\N{MINUS SIGN}")
            axes.text(x, y, text or "0", ha="center", va="center", fontsize=7.5 if width < 6 else 5.4, zorder=3)


FIGURES = {
    "beam": (
        draw_beam,
        "Logarithme de la probabilité d’une lecture, selon la lecture z en cases ; un trait vertical vert marque la "
        "distance attendue. Le rond bleu est la valeur attendue en z, la croix orange celle de votre programme.",
    ),
    "beams": (
        draw_beams,
        "En haut, un trait bleu par rayon : ce que sa lecture ajoute au logarithme de la probabilité. En bas, deux "
        "barres : la somme attendue en bleu et celle de votre programme en orange, qui devraient être de même "
        "longueur.",
    ),
    "field": (
        draw_field,
        "Trois cartes vues de dessus, ligne 0 en haut et murs en gris : les distances attendues (bleu), celles de "
        "votre programme (orange), plus vives quand elles sont grandes, et la différence, orange où vous donnez "
        "trop, bleue où trop peu.",
    ),
}
