"""What stands where this manipulation would be, for who has no script."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from curriculum.l20.figures._plan import french
from curriculum.l20.manipulations.ressorts import scene
from graders.plotting import Palette
from reference.pose_graph import chi2, edge_chi2, gauss_newton


def draw(figure: Figure, palette: Palette) -> None:
    """The graph before and after it relaxes; springs as red as they are tense."""
    graph, odometry = scene.chain()
    after = gauss_newton(graph, odometry).poses
    for axes, poses, title in zip(figure.subplots(1, 2), (odometry, after), ("l’odométrie", "détendu"), strict=True):
        levels = np.minimum(1.0, np.log10(1.0 + edge_chi2(graph, poses)) / 3.0)
        for i, j, level in zip(graph.i, graph.j, levels, strict=True):
            colour = palette.measure if level < 0.25 else palette.estimate if level < 0.75 else palette.alert
            axes.plot(*poses[[i, j], :2].T, color=colour, lw=1.2 + 2.4 * level, zorder=3)
        axes.plot(*poses[:, :2].T, "o", ms=4, color=palette.ink, zorder=4)
        for k in (0, 5, 10, 15, 20, 23):
            axes.annotate(str(k), poses[k, :2], (0, 5), textcoords="offset points", ha="center", fontsize=8, zorder=5)
        axes.set(aspect="equal", xticks=[], yticks=[], xlim=(-1.2, 7.2), ylim=(-1.2, 6.0))
        value = chi2(graph, poses)
        axes.set_title(f"{title} : χ² = {french(value, 1) if value < 100.0 else round(value)}", fontsize=10)


FIGURES = {
    "manipulation-ressorts": (
        draw,
        "À gauche, un graphe de poses d’après l’odométrie seule : les deux fermetures, rouges, sont très tendues. À "
        "droite, le même graphe détendu : tous les ressorts sont verts, et la fin du trajet a rejoint son début.",
        (6.4, 3.0),
    ),
}
