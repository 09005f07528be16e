"""What is promised of the class `ArretUrgence`."""

from __future__ import annotations

from graders.core.code.contracts import Boundary, FunctionContract
from graders.core.compare.compound_forms import OtherForm

SCENARIO = OtherForm(told="rien : `ArretUrgence()`, puis des scans dix fois par seconde")
CONTRACTS = (
    FunctionContract(
        "ArretUrgence",
        {"scénario": SCENARIO},
        OtherForm(
            told="rien : ce que le nœud publie sur `/cmd_vel` est jugé",
            accepts="nom relatif ou absolu, toute qualité de service, `declare_parameter` ou `declare_parameters`",
            outsiders=lambda value: iter(()),
        ),
        (
            Boundary("20 ou 21 rayons autour du milieu", free="un obstacle reste à deux rayons au moins des bords"),
            Boundary("un obstacle confirmé sur plusieurs scans", free="sur cinq au plus, ou dès le premier"),
            Boundary("le silence, quand la voie est libre", free="aussitôt, ou dans la demi-seconde"),
            Boundary("une lecture égale à un seuil", free="il n’y en a jamais"),
            Boundary("−inf, 0, une lecture négative ou sous range_min", free="s’arrêter ou non"),
        ),
        "est relancé pour chaque situation ; votre `main` n’est pas appelé.",
    ),
)
