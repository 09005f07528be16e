"""Figures of l20/defi_amers: the map before and after with what remains of each error, and H beside the right one."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from graders.l20.slam_graphe.figures import near
from graders.plotting import EXPECTED, OBTAINED, THIRD, ink_of

BAR = 0.38
MAX_TICKS = 12


def draw_map(figure: Figure, data: dict[str, Any]) -> None:
    """Left: the map given, the optimum and the one obtained. Right: the weighted error of each measurement, in both."""
    left, right = figure.subplots(1, 2, width_ratios=(1.25, 1.0))
    _draw_places(left, data)
    _draw_errors(right, data)
    figure.legend(*left.get_legend_handles_labels(), loc="outside lower center", ncols=4)


def _draw_places(axes: Axes, data: dict[str, Any]) -> None:
    start, expected = np.array(data["start"]), np.array(data["expected"])
    size = 0.07 * max(1.0, float(np.ptp(np.vstack([start, expected])[:, :2], axis=0).max()))
    _trajectory(axes, start, data["start_landmarks"], data, ink_of(axes), "départ", size, alpha=0.4)
    _trajectory(axes, expected, data["expected_landmarks"], data, EXPECTED, "attendu", size)
    obtained = near(data["got"], start, expected)
    if obtained is not None:
        _trajectory(axes, obtained, data["got_landmarks"], data, OBTAINED, "obtenu", size, dashed=True)
    axes.plot(*expected[0, :2], "s", color=THIRD, ms=8, label="pose fixée", zorder=5)
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(0.12)
    axes.set_xlabel("x")
    axes.set_ylabel("y")
    if data["got"] and obtained is None:
        axes.text(0.5, 0.02, "votre carte est hors du cadre", color=OBTAINED, ha="center", transform=axes.transAxes)
    axes.set_title("La carte avant et après (balises : croix)", fontsize=10)


def _trajectory(
    axes: Axes, poses: Any, places: Any, data: dict[str, Any], colour: str, name: str, size: float, *,
    alpha: float = 0.95, dashed: bool = False,
) -> None:  # fmt: skip
    style: Any = (0, (4, 2)) if dashed else "-"
    landmarks = np.array(places)
    for i, j in data["edges"]:
        axes.plot(poses[[i, j], 0], poses[[i, j], 1], color=colour, lw=1.3, ls=style, alpha=0.7 * alpha)
    for i, j in data["sightings"]:
        ends = np.vstack([poses[i, :2], landmarks[j]])
        axes.plot(ends[:, 0], ends[:, 1], color=colour, lw=0.7, ls=(0, (1, 2)), alpha=0.7 * alpha)
    tips = poses[:, :2] + size * np.column_stack([np.cos(poses[:, 2]), np.sin(poses[:, 2])])
    for (x, y), tip in zip(poses[:, :2], tips, strict=True):
        axes.plot([x, tip[0]], [y, tip[1]], color=colour, lw=2.2, alpha=alpha, solid_capstyle="round")
    axes.plot(poses[:, 0], poses[:, 1], "o", color=colour, ms=4.5, alpha=alpha, label=name)
    axes.plot(landmarks[:, 0], landmarks[:, 1], "x", color=colour, ms=8, mew=2.2, alpha=alpha)


def _draw_errors(axes: Axes, data: dict[str, Any]) -> None:
    names = [f"{i} → {j}" for i, j in data["edges"]] + [f"{i} → amer {j}" for i, j in data["sightings"]]
    where = np.arange(len(names))
    axes.barh(where - BAR / 2, data["errors_expected"], BAR, color=EXPECTED)
    if data["errors_got"]:
        axes.barh(where + BAR / 2, data["errors_got"], BAR, color=OBTAINED)
        if max(data["errors_got"]) > 50.0 * (1.0 + max(data["errors_expected"])):
            axes.set_xscale("symlog")
    ticks = where[:: 1 + len(where) // (MAX_TICKS + 1)]
    axes.set_yticks(ticks, [names[k] for k in ticks])
    axes.set_ylim(max(len(where), 3) - 0.5, -0.5)
    axes.grid(axis="y", visible=False)
    axes.set_xlim(left=0.0, right=max(axes.get_xlim()[1], 0.01))
    axes.set_xlabel("√(eᵀΩe)")
    axes.set_title("L'erreur qui reste par mesure", fontsize=10)


def draw_system(figure: Figure, data: dict[str, Any]) -> None:
    """H as it should be and as it came back, with a frame around what differs; b instead where H is right."""
    expected = np.array(data["expected"])
    got = None if data["got"] is None else np.array(data["got"])
    if got is not None and data["b"] is not None and np.abs(got - expected).max() <= 1e-4 * np.abs(expected).max():
        _draw_side(figure.subplots(), data)
        return
    panels = [("H attendue", expected)] + ([("H obtenue", got)] if got is not None else [])
    limit = float(np.abs(expected).max()) or 1.0
    for axes, (title, H) in zip(np.atleast_1d(figure.subplots(1, len(panels))), panels, strict=True):
        wrong = np.abs(H - expected) > 1e-4 * limit
        _draw_matrix(axes, H, wrong, limit, 3 * data["poses"])
        axes.set_title(title + (" (encadré : ce qui diffère)" if np.any(wrong) else ""), fontsize=10)


def _draw_side(axes: Axes, data: dict[str, Any]) -> None:
    where = np.arange(len(data["b"]))
    axes.bar(where - BAR / 2, data["b_expected"], BAR, color=EXPECTED, label="b attendu")
    axes.bar(where + BAR / 2, data["b"], BAR, color=OBTAINED, label="b obtenu")
    axes.axhline(0.0, color=ink_of(axes), lw=0.8)
    cut = 3 * data["poses"]
    axes.set_xticks(*_nodes(cut, len(where)))
    axes.axvline(cut - 0.5, color=THIRD, lw=1.6)
    axes.grid(axis="x", visible=False)
    axes.set_title("H est juste ; voici b", fontsize=10)
    axes.legend(loc="best")


def _nodes(cut: int, size: int) -> tuple[list[float], list[str]]:
    """Where the unknowns of each node stand, and its name."""
    middles = [1.0 + 3 * k for k in range(cut // 3)] + [cut + 0.5 + 2 * k for k in range((size - cut) // 2)]
    return middles, [f"x{k}" for k in range(cut // 3)] + [f"l{k}" for k in range((size - cut) // 2)]


def _draw_matrix(axes: Axes, H: Any, wrong: Any, limit: float, cut: int) -> None:
    size = len(H)
    # An arcsinh keeps small entries in sight beside large ones.
    shown = np.arcsinh(H / (0.02 * limit))
    bound = float(np.arcsinh(50.0))
    axes.imshow(shown, cmap="RdBu_r", vmin=-bound, vmax=bound, interpolation="nearest")
    if size <= 13:
        for row, column in np.ndindex(H.shape):
            if abs(H[row, column]) > 1e-3 * limit or wrong[row, column]:
                dark = abs(shown[row, column]) > 0.6 * bound
                text = f"{H[row, column]:.3g}".replace(".", ",").replace("-", "−")
                colour = "#ffffff" if dark else "#1d2733"
                axes.text(column, row, text, ha="center", va="center", fontsize=6.5, color=colour)
    for row, column in np.argwhere(wrong):
        corner = np.array([[0, 1, 1, 0, 0], [0, 0, 1, 1, 0]]) - 0.5
        axes.plot(column + corner[0], row + corner[1], color=OBTAINED, lw=1.4)
    for line in (cut - 0.5,):
        axes.axhline(line, color=THIRD, lw=1.6)
        axes.axvline(line, color=THIRD, lw=1.6)
    axes.set_xticks(*_nodes(cut, size))
    axes.set_yticks(*_nodes(cut, size))
    axes.grid(visible=False)


FIGURES = {
    "carte": (
        draw_map,
        "À gauche, la carte vue de dessus, poses en ronds et balises en croix : au départ (gris), à l’optimum "
        "attendu (bleu) et selon votre programme (orange, tirets). À droite, une barre par mesure : l’erreur "
        "pondérée qui reste, attendue en bleu, obtenue en orange.",
    ),
    "systeme": (
        draw_system,
        "Matrice H attendue et matrice H de votre programme, côte à côte, en couleurs selon le signe et la grandeur "
        "; un cadre orange entoure ce qui diffère. Si H est juste, des barres comparent le vecteur b attendu (bleu) "
        "au vôtre (orange).",
    ),
}
