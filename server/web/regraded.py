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
from server.web.verdicts import outcome_title
from server.web.words import format_mark, format_points


@dataclass(frozen=True)
class RegradedView:
    """That an attempt was graded anew: when, its points before (empty for an error of ours) and after, and why."""

    when: datetime
    before: str
    after: str
    why: tuple[str, ...]


def load_regraded_view(db: Session, grading: UUID, kind: Answered) -> RegradedView | None:
    """Build the notice beside a grading that counts since a regrade."""
    told = service.find_applied_regrade(db, grading)
    if told is None:
        return None
    before, after = format_points_pair(_points(told.before), _points(told.after))
    why = tuple(f"{text[0].upper()}{text[1:]}." for text in reason_sentences(told.differences, kind))
    return RegradedView(told.applied_at, before, after, why)


def _points(score: float | None) -> float | None:
    return None if score is None else 20.0 * score


def format_points_pair(before: float | None, after: float | None, most: float = 20.0) -> tuple[str, str]:
    """Two numbers of points as marks are read; to the hundredth, where rounding would make them one."""
    known = [points for points in (before, after) if points is not None]
    read = (
        format_points
        if len({format_mark(points, max(points, most)) for points in known}) < len(set(known))
        else _mark(most)
    )
    written = ["" if points is None else read(points) for points in (before, after)]
    return written[0], written[1]


def _mark(most: float) -> Callable[[float], str]:
    return lambda value: format_mark(value, max(value, most))


def reason_sentences(why: Sequence[VerdictDifference], kind: Answered) -> tuple[str, ...]:
    """One for each reason, without capital or full stop; titles in them are as the exercise has them."""
    return tuple(WORDS[reason.kind](reason, kind) for reason in why)


def _changed(reason: VerdictDifference, _: Answered) -> str:
    before, after = format_points_pair(reason.before, reason.after, reason.most or 0.0)
    return f"la vérification « {reason.name} » passe de {before} à {after} sur {format_points(reason.most or 0.0)}"


def _scaled(reason: VerdictDifference, _: Answered) -> str:
    now, was = format_points(reason.after or 0.0), format_points(reason.before or 0.0)
    return f"la vérification « {reason.name} » est maintenant sur {now}, et non plus sur {was}"


def _new(reason: VerdictDifference, _: Answered) -> str:
    most = reason.most or 0.0
    return (
        f"nouvelle vérification « {reason.name} » : {format_mark(reason.after or 0.0, most)} sur {format_points(most)}"
    )


def _gone(reason: VerdictDifference, _: Answered) -> str:
    most = reason.most or 0.0
    mark = format_mark(reason.before or 0.0, most)
    return f"la vérification « {reason.name} », {mark} sur {format_points(most)}, n’existe plus"


def _ended(reason: VerdictDifference, kind: Answered) -> str:
    return f"l’issue est « {outcome_title(reason.now, kind)} », et non plus « {outcome_title(reason.was, kind)} »"


def _recognised(reason: VerdictDifference, _: Answered) -> str:
    if not reason.was:
        return f"une erreur est reconnue : « {reason.now} »"
    if not reason.now:
        return f"l’erreur « {reason.was} » n’est plus reconnue"
    return f"l’erreur reconnue est « {reason.now} », et non plus « {reason.was} »"


WORDS: Mapping[DifferenceKind, Callable[[VerdictDifference, Answered], str]] = {
    "points": _changed,
    "scale": _scaled,
    "new": _new,
    "gone": _gone,
    "outcome": _ended,
    "diagnosis": _recognised,
    "example": lambda reason, _: f"la vérification « {reason.name} » montre un autre exemple, pour autant de points",
    "failed": lambda *_: "la nouvelle correction a échoué à cause d’une erreur du serveur : l’ancienne reste",
    "mended": lambda *_: "la correction d’avant avait échoué à cause d’une erreur du serveur",
}
