"""What is promised of `interpoler`, `a_la_date` and `chercher`."""

from __future__ import annotations

import numpy as np

from graders.core.code.contracts import Boundary, FunctionContract
from graders.core.compare.comparison import TOLERANCE
from graders.core.compare.compound_forms import OtherForm
from graders.core.compare.forms import NUMBER, POSE, ArrayForm, array, poses, with_tolerance
from graders.core.contract.values import Value
from graders.l20.tf_date.truth import UNKNOWN_DATE, UNKNOWN_FRAME, Message, right_at, right_lookup


def is_message(value: Value) -> bool:
    parent, child, date, pose = value
    named = type(parent) is str and type(child) is str
    return named and (date is None or type(date) is float) and type(pose) is np.ndarray and pose.shape == (3,)


MESSAGES = OtherForm(
    told="une liste de quadruplets (parent, enfant, date, pose) : deux textes, un nombre ou None, une pose (3,)",
    given=lambda value: type(value) is list and bool(value) and all(map(is_message, value)),
)
NAME = OtherForm(told="un texte", given=lambda value: type(value) is str)
PLACED: ArrayForm = with_tolerance(POSE, TOLERANCE)


def alone(messages: list[Message], target: str, source: str, date: float) -> bool:
    """Whether the only date is the one that is asked."""
    return {message[2] for message in messages} == {None, date}


CONTRACTS = (
    FunctionContract(
        "interpoler",
        {"a": POSE, "b": POSE, "part": NUMBER},
        PLACED,
        (
            Boundary("part = 0, part = 1", lambda a, b, part: part in (0.0, 1.0)),
            Boundary("un cap qui passe par π", lambda a, b, part: abs(a[2] - b[2]) > np.pi),
            Boundary("un demi-tour exact", free="il n’est pas demandé"),
            Boundary("une part hors de [0, 1]", free="elle n’est pas demandée"),
        ),
    ),
    FunctionContract(
        "a_la_date",
        {"dates": array("n"), "poses": poses(), "date": NUMBER},
        PLACED,
        (
            Boundary("la première et la dernière date, exactement", lambda d, p, date: date in (d[0], d[-1])),
            Boundary("une date seule", lambda d, p, date: len(d) == 1),
            Boundary("une date inconnue : ValueError", lambda *args: right_at(*args) is UNKNOWN_DATE),
            Boundary("le texte de l’exception", free="à votre choix"),
        ),
    ),
    FunctionContract(
        "chercher",
        {"messages": MESSAGES, "cible": NAME, "source": NAME, "date": NUMBER},
        PLACED,
        (
            Boundary("le même repère deux fois", lambda messages, target, source, date: target == source),
            Boundary("un lien fixe, à toute date", lambda messages, t, s, date: date == 99.0),
            Boundary("des messages en désordre", lambda messages, t, s, d: messages[0][2] == 3.0),
            Boundary("un seul message daté, à sa date", alone),
            Boundary("un repère que l’on n’atteint pas : KeyError", lambda *args: right_lookup(*args) is UNKNOWN_FRAME),
            Boundary("une date inconnue : ValueError", lambda *args: right_lookup(*args) is UNKNOWN_DATE),
            Boundary("le même repère inconnu, deux fois", free="ce n’est pas demandé"),
            Boundary("les deux fautes à la fois", free="ce n’est pas demandé"),
        ),
    ),
)
