"""Which script measures which table: what a text says is what a script finds, or a test tells.

`python -m tests.content.curriculum.measured.claims [PART OF A NAME]` prints what the scripts find.
"""

from __future__ import annotations

import sys

from tests.content.curriculum.measured import beliefs, graphs, particles
from tests.content.curriculum.measured.tables import Measure

MEASURES = (
    Measure("seances/localiser", "particules $N$", particles.how_many, within=(3.0, 3.0)),
    Measure("seances/slam", "poses", graphs.at_scale, times=frozenset({1})),
    Measure("cours/filtre-bayesien", "case (m)", beliefs.grid_by_hand),
    Measure("cours/filtre-bayesien", "méthode", beliefs.three_filters, within=0.001, share=0.02),
    Measure("cours/telemetre", "distance attendue $\\hat z$", beliefs.mass),
    Measure("cours/rayons", "erreur sur $x$ (cases)", beliefs.errors_of_x),
    Measure("cours/rayons", "rayons $n$", beliefs.overconfidence),
    Measure("defis/amers", "", graphs.beacons_with_and_without),
    Measure("defis/amers", "poses, balises", graphs.solving, times=frozenset({2, 3})),
    Measure("defis/kidnappe", "injection", particles.kidnapped, within=(0.04, 4.0)),
    Measure("defis/kidnappe", "on rééchantillonne si…", particles.when_to_draw, within=(2.0, 0.003, 1.0), share=0.1),
    Measure("defis/kidnappe", "tirage", particles.two_clouds, within=(0.11, 15.0)),
    Measure("defis/robuste", "méthode", graphs.false_closure, within=(0.005, 0.001, 0.01)),
    Measure("defis/robuste", "amers", graphs.updates, times=frozenset({0, 1})),
)

#: Tables of decimals that nobody measures: what is reckoned there by hand, checked elsewhere, or only defined.
BY_HAND = {
    ("seances/slam", "variante"): "the iterations of ICP: tests/content/curriculum/test_lessons.py",
    ("seances/slam", "arête"): "four poses on a line, by hand: tests/content/curriculum/test_lessons.py",
    ("annexes/notations", "ici"): "conventions",
    ("annexes/notations", "expression en Python"): "conventions",
    ("exercices/predire2d/enonce", "probabilité"): "what the exercise supposes",
    ("exercices/lidar/enonce", "angle"): "an example: tests/content/curriculum/test_examples.py",
    ("exercices/modele_faisceau/enonce", "lecture $z$"): "an example: tests/content/curriculum/test_examples.py",
    ("exercices/occupation/enonce", "case"): "what the exercise supposes",
    ("exercices/occupation/enonce", "case de la ligne 2"): "an example: tests/content/curriculum/test_examples.py",
    ("exercices/association/enonce", ""): "by hand: tests/content/graders/l20/test_association.py",
    ("exercices/calibration/enonce", "compté"): "by hand: tests/content/graders/l20/test_calibration.py",
    ("exercices/tp_slam/enonce", "arêtes"): "what the exercise supposes",
    ("exercices/tp_slam/enonce", "d'où viennent les poses"): "the same figures as those of the page of the TP",
    (
        "exercices/noeud_ros/enonce",
        "`distance_min`",
    ): "asked by the exercise: tests/content/graders/l20/test_noeud_ros.py",
}


def main(arguments: list[str]) -> None:
    for measure in MEASURES:
        if all(part in f"{measure.page} {measure.head}" for part in arguments):
            print(f"{measure.page} | {measure.head}")
            for row in measure.rows():
                print("   ", *row)


if __name__ == "__main__":
    main(sys.argv[1:])
