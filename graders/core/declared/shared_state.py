"""State that a program keeps from one case to the next: a case that fails after others may pass alone."""

from __future__ import annotations

from contextlib import closing

from graders.core.code.stateless import may_keep_state
from graders.core.declared.declaration import DeclaredCheck
from graders.core.declared.judging import FailedCase, judge
from graders.core.declared.playing import Player

PASSES_ALONE = (
    "Appelé seul, dans un programme neuf, c’est juste : votre programme garde quelque chose des appels d’avant. Un "
    "attribut de classe est commun à tous les objets ; une variable globale ou une liste par défaut restent d’un appel "
    "au suivant."
)


def replay_failure_alone(
    check: DeclaredCheck, failure: FailedCase, source: bytes, student: Player
) -> tuple[FailedCase, str]:
    """Return the failure of the same case in a program that has played nothing, so that a replay shows the same.

    Where it passes there, return the failure after the other cases, and the words that say so. A program whose text
    shows no state is not launched again.
    """
    if not may_keep_state(source) or (failure.got.fault is not None and failure.got.fault.fatal):
        return failure, ""
    with closing(student.make_fresh_player()) as fresh:
        (got,) = fresh.play([failure.case.scenario])
    if got.fault is not None and got.fault.fatal:
        return failure, ""
    alone = judge(check, failure.case, failure.right, got)
    return (failure, PASSES_ALONE) if alone is None else (alone, "")
