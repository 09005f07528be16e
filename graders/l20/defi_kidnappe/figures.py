"""Figures of l20/defi_kidnappe: the drawings of l20/mcl."""

from graders.l20.mcl.figures import draw_cloud, draw_run

FIGURES = {
    "cloud": (
        draw_cloud,
        "Carte vue de dessus, murs en gris : les points orange sont votre nuage, avec un trait pour le cap de "
        "chaque particule, et le cercle bleu est le robot. Le nuage devrait se rassembler autour du robot.",
    ),
    "run": (
        draw_run,
        "Carte vue de dessus après l’enlèvement, murs en gris : en bleu, le trajet du robot ; en tirets orange, vos "
        "estimations ; en points orange, vos particules à la fin. Les estimations devraient rejoindre le trajet "
        "bleu.",
    ),
}
