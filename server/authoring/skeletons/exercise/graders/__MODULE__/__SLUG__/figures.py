"""Les dessins des contre-exemples, faits quand quelqu'un les regarde."""

from graders.plotting import EXPECTED, OBTAINED, ink_of


def draw_path(figure, data):
    """Le chemin, le point attendu et, s'il se dessine, le point obtenu (`got` vaut None sinon)."""
    axes = figure.add_subplot()
    ink = ink_of(axes)
    axes.plot([data["a"], data["b"]], [0, 0], color=ink, marker="|", markersize=14)
    for name in ("a", "b"):
        axes.annotate(name, (data[name], 0), textcoords="offset points", xytext=(0, 12), ha="center", color=ink)
    axes.plot(data["expected"], 0, "o", color=EXPECTED, label="attendu")
    if data["got"] is not None:
        axes.plot(data["got"], 0, "X", color=OBTAINED, label="obtenu")
    axes.set_yticks([])
    axes.legend()


FIGURES = {
    "chemin": (
        draw_path,
        "Un segment de a à b, avec en bleu le point attendu et en orange celui de votre programme.",
    ),
}
