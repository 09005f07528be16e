"""l20/tf_date: where a frame was at the date of a scan, as tf2 answers it, and when it must refuse to.

Nothing is left to chance: dates are whole milliseconds, and no turn is ambiguous.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from graders.core.code.checks import Cases, Untouched
from graders.core.code.exercise import code
from graders.core.compare.shrinking import keep_unchanged
from graders.core.contract.values import Arguments
from graders.l20 import world
from graders.l20.tf_date import cases
from graders.l20.tf_date.checks import SAME, Answers
from graders.l20.tf_date.contract import CONTRACTS
from graders.l20.tf_date.pictures import between_figure, chain_figure, history_figure
from graders.l20.tf_date.probes import PROBES
from graders.l20.tf_date.truth import right_at, right_between, right_lookup
from graders.robotics.poses import shrink_pose

BETWEEN, AT, LOOKUP = ("interpoler",), ("a_la_date",), ("chercher",)
PAIR = ("a", "b", "part")
HISTORY = ("dates", "poses", "date")
TREE = ("messages", "cible", "source", "date")


def shorter_histories(args: Arguments) -> Iterator[Arguments]:
    """Without one of the dates."""
    dates, poses, date = args
    if len(dates) > 1:
        yield from ((np.delete(dates, k), np.delete(poses, k, axis=0), date) for k in range(len(dates)))


def fewer_messages(args: Arguments) -> Iterator[Arguments]:
    """Without one of the messages."""
    messages, target, source, date = args
    yield from (([*messages[:k], *messages[k + 1 :]], target, source, date) for k in range(len(messages)))


def arguments_to_keep(rng: np.random.Generator) -> dict[str, Arguments]:
    shuffled = [(*message[:3], message[3].copy()) for message in cases.SHUFFLED]
    return {
        "interpoler": (cases.pose(0, 2, 1.7), cases.pose(4, 0, -1.7), 0.7),
        "a_la_date": (np.array([0.0, 1.0, 5.0]), np.array([[0.0, 0, 0], [1, 0, 1], [5, 4, 2]]), 2.0),
        "chercher": ([*shuffled, cases.fixed("base", "laser", 1, 0, 2)], "odom", "laser", 1.5),
    }


Pairs = partial(
    Cases,
    functions=BETWEEN,
    names=PAIR,
    expected=right_between,
    compare=SAME,
    shrinkers=(shrink_pose, shrink_pose, keep_unchanged),
    figure=between_figure,
)
Histories = partial(
    Answers,
    functions=AT,
    names=HISTORY,
    expected=right_at,
    simpler=shorter_histories,
    valid=cases.is_history,
    figure=history_figure,
)
Lookups = partial(
    Answers,
    functions=LOOKUP,
    names=TREE,
    expected=right_lookup,
    simpler=fewer_messages,
    valid=cases.are_messages,
    figure=chain_figure,
)

CHECKS = (
    Pairs(
        id="entre_deux",
        title="Entre deux poses",
        points=3,
        cases=cases.plain_pairs,
        valid=cases.turns_ahead,
        hint="Que renvoyez-vous pour part = 0, et pour part = 1 ? Lequel des deux poids va à b ?",
    ),
    Pairs(
        id="par_le_plus_court",
        title="Entre deux poses, quand le cap passe par un demi-tour",
        points=3,
        cases=cases.pairs_across_the_back,
        valid=cases.turns_across_the_back,
        hint="De 3 rad à −3 rad, de combien tourne-t-on par le plus court ? Et quel cap a-t-on à mi-chemin ?",
    ),
    Histories(
        id="date_connue",
        title="À une date, parmi celles qui sont connues",
        points=4,
        cases=cases.dates_inside,
        hint="Quelles sont les deux dates qui encadrent celle que l'on demande, et quelle part de leur écart a passé ?",
    ),
    Histories(
        id="date_inconnue",
        title="Ni avant la première date, ni après la dernière",
        points=2,
        cases=cases.dates_at_the_ends,
        hint="Que renvoie votre fonction une seconde après la dernière date ? Et à la dernière date elle-même ?",
    ),
    Lookups(
        id="chaine",
        title="D'un repère à l'autre, à la date du scan",
        points=4,
        cases=cases.chains,
        hint="À chaque repère que vous remontez : quelle est la pose de l'enfant dans son parent, et de quel côté se "
        "compose-t-elle ?",
    ),
    Lookups(
        id="refus",
        title="Refuser plutôt que deviner, et seulement alors",
        points=3,
        cases=cases.refusals,
        hint="Quels liens sont sur le chemin de la source à la cible ? Tous sont-ils connus à cette date ?",
    ),
    Untouched(
        id="arguments",
        title="Les tableaux et la liste donnés restent intacts",
        points=1,
        functions=(*BETWEEN, *AT, *LOOKUP),
        names={"interpoler": PAIR, "a_la_date": HISTORY, "chercher": TREE},
        inputs=arguments_to_keep,
        hint="messages.sort() range la liste de celui qui appelle ; sorted(messages) en fait une autre. Et T += … ?",
    ),
)

DEFINITION = code(__file__, checks=CHECKS, kit=world.kit, contracts=CONTRACTS, probes=PROBES)
