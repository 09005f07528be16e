"""A drawing of the lesson on research: forty years of ideas, by family."""

from __future__ import annotations

from matplotlib.figure import Figure

from graders.plotting import Palette

#: Year, what came then, and its line: filters, graphs, maps, cameras.
LINES = ("filtres", "graphes", "cartes", "caméras")
IDEAS = (
    (1985, "grille d’occupation", 2),
    (1990, "EKF-SLAM", 0),
    (1992, "ICP", 1),
    (1997, "graphe de poses", 1),
    (1999, "localisation de\nMonte-Carlo", 0),
    (2002, "FastSLAM", 0),
    (2007, "MonoSLAM", 3),
    (2011, "g2o", 1),
    (2011, "KinectFusion", 2),
    (2015, "ORB-SLAM", 3),
    (2016, "Cartographer", 1),
    (2019, "SE-Sync", 1),
    (2020, "NeRF", 2),
    (2021, "DROID-SLAM", 3),
    (2023, "gaussiennes", 2),
)


def draw_timeline(figure: Figure, palette: Palette) -> None:
    axes = figure.subplots()
    colours = (palette.truth, palette.estimate, palette.measure, palette.second)
    last: dict[int, bool] = {}
    for year, name, line in IDEAS:
        above = last[line] = not last.get(line, False)
        colour = colours[line]
        axes.plot(year, -line, "o", color=colour, ms=7, zorder=3)
        axes.annotate(
            name,
            (year, -line),
            (0, 9 if above else -9),
            textcoords="offset points",
            ha="center",
            va="bottom" if above else "top",
            fontsize=9.5,
        )
    for line, name in enumerate(LINES):
        axes.plot([1983, 2026], [-line, -line], color=colours[line], lw=1.4, alpha=0.5, zorder=1)
        axes.text(1982.4, -line, name, ha="right", va="center", color=colours[line], weight="bold", fontsize=10)
    axes.set(xlim=(1976, 2027), ylim=(-3.6, 0.6), yticks=[], xticks=[1985, 1995, 2005, 2015, 2025])
    axes.spines["left"].set_visible(False)
    axes.grid(False)


FIGURES = {
    "recherche-frise": (
        draw_timeline,
        "Frise de 1985 à 2025 en quatre lignes. Filtres : EKF-SLAM, localisation de Monte-Carlo, FastSLAM. Graphes : "
        "ICP, graphe de poses, g2o, Cartographer, SE-Sync. Cartes : grille d’occupation, KinectFusion, NeRF, nuages de "
        "gaussiennes. Caméras : MonoSLAM, ORB-SLAM, DROID-SLAM.",
        (5.6, 3.5),
    ),
}
