"""The pages of regrades."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from typing import Any
from uuid import UUID

from sqlalchemy.orm import Session

from server.assignments import repository as assignments
from server.classes import repository as classes
from server.classes.models import ClassRole, Status
from server.course import Course
from server.desk.views import class_head
from server.marks import repository as marks
from server.regrades import service
from server.regrades.models import Regrade, RegradePolicy, RegradeScope
from server.regrades.schemas import MarkChange, MarkOutcome, RegradeProgress, RegradeState
from server.regrades.service import RegradeService
from server.rights.service import ClassAccess
from server.web import regraded
from server.web.words import count_with_noun, format_points

PATH = "/recalculs"
SAME_POINTS = 1e-6
POLICIES: Mapping[RegradePolicy, str] = {
    RegradePolicy.keep_best: "garder la meilleure note",
    RegradePolicy.renew: "remplacer la note",
}
STATES: Mapping[RegradeState, str] = {
    RegradeState.running: "en cours",
    RegradeState.ready: "prête, pas encore appliquée",
    RegradeState.applied: "appliquée",
    RegradeState.undone: "annulée",
    RegradeState.stopped: "arrêtée",
}
GONE_STUDENT, GONE_ASSIGNMENT = "un élève dont le compte n’existe plus", "un devoir supprimé"
#: The titles of each outcome, for one student and for several: before the regrade is applied, and after.
PREVIEW_TITLES: Mapping[MarkOutcome, tuple[str, str]] = {
    MarkOutcome.loses: ("élève perdrait des points", "élèves perdraient des points"),
    MarkOutcome.gains: ("élève gagnerait des points", "élèves gagneraient des points"),
    MarkOutcome.kept: (
        "élève garderait sa note, que la nouvelle version baisserait",
        "élèves garderaient leur note, que la nouvelle version baisserait",
    ),
    MarkOutcome.same: ("élève aurait la même note", "élèves auraient la même note"),
}
APPLIED_TITLES: Mapping[MarkOutcome, tuple[str, str]] = {
    MarkOutcome.loses: ("élève a perdu des points", "élèves ont perdu des points"),
    MarkOutcome.gains: ("élève a gagné des points", "élèves ont gagné des points"),
    MarkOutcome.kept: (
        "élève a gardé sa note, que la nouvelle version baissait",
        "élèves ont gardé leur note, que la nouvelle version baissait",
    ),
    MarkOutcome.same: ("élève a la même note", "élèves ont la même note"),
}
OUTCOME_SIGNS: Mapping[MarkOutcome, tuple[str, str]] = {
    MarkOutcome.loses: ("▼", "bad"),
    MarkOutcome.gains: ("▲", "good"),
    MarkOutcome.kept: ("=", "plain"),
    MarkOutcome.same: ("=", "plain"),
}


def regrade_href(regrade: Regrade) -> str:
    return f"/classes/{regrade.class_id}{PATH}/{regrade.id}"


def build_regrades_page(db: Session, course: Course, access: ClassAccess, regrades: RegradeService) -> dict[str, Any]:
    school_class = access.school_class
    return {
        "head": class_head(course, access, PATH),
        "outdated": regrades.load_outdated_exercises(db, school_class),
        "exercises": regrades.load_exercise_titles(db, school_class),
        "names": _ClassNames(db, school_class.id),
        "policies": POLICIES,
        "states": STATES,
        "rows": service.load_regrade_history(db, school_class.id),
    }


class _ClassNames:
    """The names of a class's people and the titles of its assignments, read once for a page."""

    def __init__(self, db: Session, class_id: UUID) -> None:
        everyone = classes.load_members(db, class_id)
        self.people = {member.id: member.name for member in everyone}
        self.active = [
            member for member in everyone if member.role is ClassRole.student and member.status is Status.active
        ]
        self.assignments = {
            assignment.id: assignment.title for assignment in assignments.load_class_assignments(db, class_id)
        }

    def scope(self, regrade: Regrade) -> str:
        """Return in words whose attempts are regraded."""
        if regrade.scope == RegradeScope.assignment:
            title = self.assignments.get(regrade.assignment_id) if regrade.assignment_id else None
            return f"devoir « {title} »" if title else GONE_ASSIGNMENT
        if regrade.scope == RegradeScope.student:
            return (self.people.get(regrade.student_id) if regrade.student_id else None) or GONE_STUDENT
        return "toute la classe"


def build_regrade_page(db: Session, course: Course, access: ClassAccess, regrade: Regrade) -> dict[str, Any]:
    preview = service.preview_regrade(db, regrade)
    changes, progress = preview.changes, preview.progress
    overrides = marks.load_prevailing_overrides(
        db, regrade.class_id, [change.student for change in changes], [regrade.exercise]
    )
    exercise = course.exercises.get(regrade.exercise)
    failed = sum(change.failed for change in changes)
    return {
        "head": class_head(course, access, PATH),
        "regrade": regrade,
        "progress": progress,
        "progress_text": progress_text(progress),
        "names": _ClassNames(db, regrade.class_id),
        "policies": POLICIES,
        "failed": failed,
        "changes_nothing": not failed and all(change.outcome is MarkOutcome.same for change in changes),
        "groups": list(_outcome_groups(changes, progress)),
        "overridden": {student for student, _ in overrides},
        "texts": None if exercise is None or exercise.answers is None else exercise,
        "points_pair": regraded.format_points_pair,
        "difference": _format_difference,
        "reasons": partial(regraded.verdict_difference_sentences, kind="code" if exercise is None else exercise.kind),
    }


def progress_text(advance: RegradeProgress) -> str:
    return f"{advance.graded} sur {count_with_noun(advance.total, 'copie', 'copies')}"


def _outcome_groups(changes: Sequence[MarkChange], progress: RegradeProgress) -> Iterator[dict[str, Any]]:
    """Group the changes by outcome; the group of unchanged marks is folded."""
    titles = APPLIED_TITLES if progress.state is RegradeState.applied else PREVIEW_TITLES
    for outcome, (sign, tone) in OUTCOME_SIGNS.items():
        same = [change for change in changes if change.outcome is outcome]
        if same:
            title, folded = count_with_noun(len(same), *titles[outcome]), outcome is MarkOutcome.same
            yield {
                "id": outcome.value, "title": title, "sign": sign, "tone": tone, "folded": folded, "changes": same
            }  # fmt: skip


def _format_difference(before: float | None, after: float | None) -> str:
    difference = (after or 0.0) - (before or 0.0)
    if abs(difference) < SAME_POINTS:
        return "0"
    return f"{'+' if difference > 0 else '−'}{format_points(abs(difference))}"
