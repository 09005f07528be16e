"""Describes the differences between two gradings of an attempt, in French."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from uuid import UUID

from sqlalchemy.orm import Session

from graders.core.contract.outcomes import Kind as Answered
from server.regrades import service
from server.regrades.differences import DifferenceKind, VerdictDifference
from server.web.verdicts import outcome_in_words
from server.web.words import format_mark, format_points


@dataclass(frozen=True)
class RegradeNotice:
    """That an attempt was graded anew: when, its points before (empty for an error of ours) and after, and why."""

    when: datetime
    before: str
    after: str
    why: tuple[str, ...]


def load_regrade_notice(db: Session, grading: UUID, kind: Answered) -> RegradeNotice | None:
    """Build the notice beside a grading that counts since a regrade."""
    told = service.find_applied_regrade(db, grading)
    if told is None:
        return None
    before, after = format_points_pair(_score_to_points(told.before), _score_to_points(told.after))
    why = tuple(f"{text[0].upper()}{text[1:]}." for text in verdict_difference_sentences(told.differences, kind))
    return RegradeNotice(told.applied_at, before, after, why)


def _score_to_points(score: float | None) -> float | None:
    return None if score is None else 20.0 * score


def format_points_pair(before: float | None, after: float | None, most: float = 20.0) -> tuple[str, str]:
    """Two numbers of points as marks are read; to the hundredth, where rounding would make them one."""
    known = [points for points in (before, after) if points is not None]
    read = (
        format_points
        if len({format_mark(points, max(points, most)) for points in known}) < len(set(known))
        else _mark_formatter(most)
    )
    written = ["" if points is None else read(points) for points in (before, after)]
    return written[0], written[1]


def _mark_formatter(most: float) -> Callable[[float], str]:
    return lambda value: format_mark(value, max(value, most))


def verdict_difference_sentences(differences: Sequence[VerdictDifference], kind: Answered) -> tuple[str, ...]:
    """One for each reason, without capital or full stop; titles in them are as the exercise has them."""
    return tuple(WORDS[reason.kind](reason, kind) for reason in differences)


def _describe_changed_points(reason: VerdictDifference, _: Answered) -> str:
    before, after = format_points_pair(reason.before, reason.after, reason.most or 0.0)
    return f"la vérification « {reason.name} » passe de {before} à {after} sur {format_points(reason.most or 0.0)}"


def _describe_changed_scale(reason: VerdictDifference, _: Answered) -> str:
    now, was = format_points(reason.after or 0.0), format_points(reason.before or 0.0)
    return f"la vérification « {reason.name} » est maintenant sur {now}, et non plus sur {was}"


def _describe_new_check(reason: VerdictDifference, _: Answered) -> str:
    most = reason.most or 0.0
    return (
        f"nouvelle vérification « {reason.name} » : {format_mark(reason.after or 0.0, most)} sur {format_points(most)}"
    )


def _describe_removed_check(reason: VerdictDifference, _: Answered) -> str:
    most = reason.most or 0.0
    mark = format_mark(reason.before or 0.0, most)
    return f"la vérification « {reason.name} », {mark} sur {format_points(most)}, n’existe plus"


def _describe_changed_outcome(reason: VerdictDifference, kind: Answered) -> str:
    return f"l’issue est « {outcome_in_words(reason.now, kind)} », et non plus « {outcome_in_words(reason.was, kind)} »"


def _describe_changed_diagnosis(reason: VerdictDifference, _: Answered) -> str:
    if not reason.was:
        return f"une erreur est reconnue : « {reason.now} »"
    if not reason.now:
        return f"l’erreur « {reason.was} » n’est plus reconnue"
    return f"l’erreur reconnue est « {reason.now} », et non plus « {reason.was} »"


WORDS: Mapping[DifferenceKind, Callable[[VerdictDifference, Answered], str]] = {
    "points": _describe_changed_points,
    "scale": _describe_changed_scale,
    "new": _describe_new_check,
    "gone": _describe_removed_check,
    "outcome": _describe_changed_outcome,
    "diagnosis": _describe_changed_diagnosis,
    "example": lambda reason, _: f"la vérification « {reason.name} » montre un autre exemple, pour autant de points",
    "failed": lambda *_: "la nouvelle correction a échoué à cause d’une erreur du serveur : l’ancienne reste",
    "mended": lambda *_: "la correction d’avant avait échoué à cause d’une erreur du serveur",
}
