"""Figures of l20/predire2d: beliefs as heat over the map, the expected one beside the one obtained."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import Colormap, LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.image import AxesImage

from graders.core.contract.values import Floats
from graders.plotting import EXPECTED, OBTAINED, THIRD, ink_of

GAMMA = 0.5


def draw_beliefs(figure: Figure, data: dict[str, Any]) -> None:
    """The belief given, the one expected, the one obtained, and obtained minus expected."""
    free, given, expected = (np.array(data[key], dtype=float) for key in ("free", "given", "expected"))
    got = None if data["got"] is None else np.array(data["got"], dtype=float)
    panels = figure.subplots(2, 2)
    given_axes, expected_axes, got_axes, gap_axes = panels.ravel()
    _belief(given_axes, free, given, "Donnée" + _asked(data), THIRD)
    _belief(expected_axes, free, expected, "Attendue", EXPECTED)
    if data["command"] and any(data["command"]):
        _arrow(given_axes, given, data["command"])
    if got is None:
        for axes, title in ((got_axes, "Obtenue"), (gap_axes, "Différence")):
            _belief(axes, free, np.zeros_like(expected), f"{title} : rien à dessiner", OBTAINED)
        return
    _belief(got_axes, free, got, "Obtenue", OBTAINED)
    _difference(gap_axes, free, got - expected)


def _asked(data: dict[str, Any]) -> str:
    if data["command"]:
        du, dv = data["command"]
        return f", ordre ({du}, {dv})".replace("-", "\N{MINUS SIGN}")
    return f", scan [{' ; '.join(data['scan'])}]"


def _belief(axes: Axes, free: Floats, belief: Floats, title: str, colour: str) -> None:
    """Probabilities by depth of colour (square root: small ones stay visible), negative ones as nothing."""
    top = max(float(belief.max()), 1e-12)
    shade = (np.clip(belief, 0.0, None) / top) ** GAMMA
    _map(axes, free, title)
    _heat(axes, shade, _ramp(axes, colour), (0.0, 1.0))
    _label(axes, belief)


def _difference(axes: Axes, free: Floats, gap: Floats) -> None:
    """Too much in orange, too little in blue."""
    top = max(float(np.abs(gap).max()), 1e-12)
    ramp = LinearSegmentedColormap.from_list("gap", [EXPECTED, axes.get_facecolor(), OBTAINED])
    _map(axes, free, "Obtenue \N{MINUS SIGN} attendue")
    _heat(axes, np.sign(gap) * (np.abs(gap) / top) ** GAMMA, ramp, (-1.0, 1.0))
    _label(axes, gap)


def _ramp(axes: Axes, colour: str) -> Colormap:
    return LinearSegmentedColormap.from_list(colour, [axes.get_facecolor(), colour])


def _heat(axes: Axes, values: Floats, ramp: Colormap, limits: tuple[float, float]) -> AxesImage:
    shown = np.ma.masked_where(np.abs(values) < 1e-4, values)
    return axes.imshow(shown, cmap=ramp, vmin=limits[0], vmax=limits[1], interpolation="nearest", zorder=2)


def _map(axes: Axes, free: Floats, title: str) -> None:
    """The walls, row 0 at the top as in the printed array, and as many ticks as can be read."""
    height, width = free.shape
    walls = np.ma.masked_where(free > 0.5, np.ones_like(free))
    wall = LinearSegmentedColormap.from_list("walls", [ink_of(axes), ink_of(axes)])
    axes.imshow(walls, cmap=wall, alpha=0.35, interpolation="nearest", zorder=1)
    axes.set_xticks(range(0, width, 4 if width > 12 else 1))
    axes.set_yticks(range(0, height, 4 if height > 12 else 1))
    axes.tick_params(length=2, labelsize=7.5)
    axes.grid(False)
    axes.set_xlim(-0.5, width - 0.5)
    axes.set_ylim(height - 0.5, -0.5)
    for side in ("top", "right", "left", "bottom"):
        axes.spines[side].set_visible(True)
    axes.set_title(title, fontsize=10)


def _label(axes: Axes, values: Floats) -> None:
    """The numbers themselves, when the map is small enough to hold them."""
    if values.shape[1] > 10:
        return
    for y, x in np.argwhere(np.abs(values) >= 0.005):
        text = f"{values[y, x]:.2f}".replace(".", ",").replace("-", "\N{MINUS SIGN}")
        axes.text(x, y, text, ha="center", va="center", fontsize=5.8, zorder=3)


def _arrow(axes: Axes, given: Floats, command: list[int]) -> None:
    """The command, drawn from the likeliest cell."""
    y, x = np.unravel_index(int(np.argmax(given)), given.shape)
    tip = (x + 1.6 * command[0], y + 1.6 * command[1])
    style = {"arrowstyle": "-|>", "color": ink_of(axes), "lw": 1.4, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", xy=tip, xytext=(float(x), float(y)), arrowprops=style, zorder=4)


def draw_localisation(figure: Figure, data: dict[str, Any]) -> None:
    """The final beliefs over the map, with the way that the robot really went."""
    free, expected = np.array(data["free"], dtype=float), np.array(data["expected"], dtype=float)
    got = np.zeros_like(expected) if data["got"] is None else np.array(data["got"], dtype=float)
    figure.set_size_inches(6.4, 2.9)
    left, right = figure.subplots(1, 2)
    figure.suptitle("Croyance après huit pas, et chemin réel du robot", fontsize=11)
    for axes, belief, title, colour in ((left, expected, "Attendue", EXPECTED), (right, got, "Obtenue", OBTAINED)):
        _belief(axes, free, belief, title, colour)
        _path(axes, data["path"], belief, colour)
    figure.legend(handles=left.get_legend_handles_labels()[0], loc="outside lower center", ncols=3)


def _path(axes: Axes, path: list[list[int]], belief: Floats, colour: str) -> None:
    ink = ink_of(axes)
    y, x = np.array(path, dtype=float).T
    axes.plot(x, y, "-", color=ink, lw=1.1, zorder=3)
    axes.plot(x[:1], y[:1], "o", color=ink, ms=4, mfc="none", zorder=4, label="départ")
    axes.plot(x[-1:], y[-1:], "o", color=ink, ms=5, zorder=4, label="arrivée du robot")
    row, column = np.unravel_index(int(np.argmax(belief)), belief.shape)
    axes.plot([column], [row], "X", color=colour, mec=ink, mew=0.8, ms=8, zorder=5, label="maximum de la croyance")


FIGURES = {
    "beliefs": (
        draw_beliefs,
        "Quatre cartes vues de dessus, ligne 0 en haut et murs en gris, plus vives où la probabilité est grande : "
        "la croyance donnée (vert), celle que l’on attend (bleu), la vôtre (orange), et la différence, orange où il "
        "y a trop, bleue où trop peu.",
    ),
    "localisation": (
        draw_localisation,
        "Deux cartes vues de dessus, murs en gris : la croyance attendue (bleu) et la vôtre (orange) après huit "
        "pas, avec le chemin réel du robot. Une croix marque le maximum de chaque croyance, qui devrait être à "
        "l’arrivée du robot.",
    ),
}
