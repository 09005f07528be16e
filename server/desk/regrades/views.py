"""From regrades to what the templates show."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Literal
from uuid import UUID

from sqlalchemy.orm import Session

from graders.core.contract.outcomes import Kind
from server.assignments import repository as assignments
from server.classes import repository as classes
from server.classes.models import ClassRole, Status
from server.course import Course
from server.desk.regrades.schemas import (
    MarkChangeRow,
    OutcomeGroup,
    OutdatedExerciseRow,
    RegradePage,
    RegradeRow,
    RegradesPage,
    Tone,
)
from server.desk.views import class_head
from server.marks import repository as marks
from server.regrades import service
from server.regrades.models import Regrade, RegradePolicy, RegradeScope
from server.regrades.schemas import MarkChange, MarkOutcome, OutdatedExercise, RegradeProgress, RegradeState
from server.regrades.service import RegradeService
from server.rights.service import ClassAccess
from server.web import regraded
from server.web.words import format_points, iso_moment, plural, short_moment

PATH = "/recalculs"
SAME_POINTS = 1e-6
POLICIES: Mapping[RegradePolicy, str] = {
    RegradePolicy.keep_best: "garder la meilleure note",
    RegradePolicy.renew: "remplacer la note",
}
STATES: Mapping[RegradeState, tuple[str, Literal["", "good", "warn"]]] = {
    RegradeState.running: ("en cours", "warn"),
    RegradeState.ready: ("prête, pas encore appliquée", "warn"),
    RegradeState.applied: ("appliquée", "good"),
    RegradeState.undone: ("annulée", ""),
    RegradeState.stopped: ("arrêtée", ""),
}
GONE_STUDENT, GONE_ASSIGNMENT = "un élève dont le compte n’existe plus", "un devoir supprimé"
OVERRIDDEN_NOTE = "note modifiée à la main : elle reste celle qui compte, et sera à revoir"
NOBODY = "Élève sorti de la classe"
#: Of each fate, for one student and for several: what it is while it is to come, and once it is applied.
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
OUTCOME_SIGNS: Mapping[MarkOutcome, tuple[str, Tone]] = {
    MarkOutcome.loses: ("▼", "bad"),
    MarkOutcome.gains: ("▲", "good"),
    MarkOutcome.kept: ("=", "plain"),
    MarkOutcome.same: ("=", "plain"),
}


def regrade_href(regrade: Regrade) -> str:
    return f"/classes/{regrade.class_id}{PATH}/{regrade.id}"


def build_regrades_page(db: Session, course: Course, access: ClassAccess, regrades: RegradeService) -> RegradesPage:
    school_class = access.school_class
    titles = regrades.exercises(school_class)
    names = _ClassNames(db, course, school_class.id)
    return RegradesPage(
        head=class_head(course, access, PATH),
        outdated=tuple(
            _outdated_row(outdated, titles[outdated.exercise]) for outdated in regrades.outdated(db, school_class)
        ),
        exercises=tuple(titles.items()),
        assignments=tuple((str(name), title) for name, title in names.assignments.items()),
        students=tuple((str(name), names.people[name]) for name in names.active),
        rows=tuple(names.row(regrade, state) for regrade, state in service.load_history(db, school_class.id)),
    )


def _outdated_row(outdated: OutdatedExercise, title: str) -> OutdatedExerciseRow:
    attempts = plural(outdated.attempts, "copie", "copies")
    was = "a été corrigée" if outdated.attempts < 2 else "ont été corrigées"
    words = f"{attempts} de {plural(outdated.students, 'élève')} {was} par une version plus ancienne"
    return OutdatedExerciseRow(outdated.exercise, title, words)


class _ClassNames:
    """Of whom and of what regrades of a class speak, read once for a page."""

    def __init__(self, db: Session, course: Course, class_id: UUID) -> None:
        self._course = course
        self.overridden: frozenset[UUID] = frozenset()
        everyone = classes.load_members(db, class_id)
        students = [member for member in everyone if member.role is ClassRole.student]
        self.people = {member.id: member.name for member in everyone}
        self.active = [student.id for student in students if student.status is Status.active]
        self.assignments = {
            assignment.id: assignment.title for assignment in assignments.load_class_assignments(db, class_id)
        }

    def row(self, regrade: Regrade, advance: RegradeProgress) -> RegradeRow:
        exercise = self._course.exercises.get(regrade.exercise)
        words, tone = STATES[advance.state]
        return RegradeRow(
            href=regrade_href(regrade),
            title=exercise.title if exercise else regrade.exercise,
            scope=self._scope(regrade),
            policy=POLICIES[RegradePolicy(regrade.policy)],
            when=iso_moment(regrade.created_at),
            when_text=short_moment(regrade.created_at),
            state=words,
            tone=tone,
        )

    def _scope(self, regrade: Regrade) -> str:
        if regrade.scope == RegradeScope.assignment:
            title = self.assignments.get(regrade.assignment_id) if regrade.assignment_id else None
            return f"devoir « {title} »" if title else GONE_ASSIGNMENT
        if regrade.scope == RegradeScope.student:
            return (self.people.get(regrade.student_id) if regrade.student_id else None) or GONE_STUDENT
        return "toute la classe"


def build_regrade_page(db: Session, course: Course, access: ClassAccess, regrade: Regrade) -> RegradePage:
    found = service.preview_regrade(db, regrade)
    names = _ClassNames(db, course, regrade.class_id)
    set_by_hand = marks.load_exercise_overrides(
        db, regrade.class_id, [mark_change.student for mark_change in found.changes], [regrade.exercise]
    )
    names.overridden = frozenset(student for student, _ in set_by_hand)
    exercise = course.exercises.get(regrade.exercise)
    advance = found.progress
    return RegradePage(
        head=class_head(course, access, PATH),
        regrade=names.row(regrade, advance),
        state=advance.state,
        graded=advance.graded,
        total=advance.total,
        progress=progress_text(advance),
        failed=sum(change.failed for change in found.changes),
        groups=tuple(_outcome_groups(found.changes, names, advance, "code" if exercise is None else exercise.kind)),
        texts=None if exercise is None or exercise.answers is None else exercise,
    )


def progress_text(advance: RegradeProgress) -> str:
    return f"{advance.graded} sur {plural(advance.total, 'copie', 'copies')}"


def _outcome_groups(
    changes: Sequence[MarkChange], names: _ClassNames, advance: RegradeProgress, kind: Kind
) -> Iterator[OutcomeGroup]:
    words = APPLIED_TITLES if advance.state is RegradeState.applied else PREVIEW_TITLES
    for fate, (sign, tone) in OUTCOME_SIGNS.items():
        rows = tuple(_mark_change_row(change, names, kind) for change in changes if change.outcome is fate)
        if rows:
            title = plural(len(rows), *words[fate])
            yield OutcomeGroup(fate.value, title, sign, tone, fate is MarkOutcome.same, rows)


def _mark_change_row(change: MarkChange, names: _ClassNames, kind: Kind) -> MarkChangeRow:
    shown = change.new_only if change.outcome is MarkOutcome.kept else change.after
    before, after = regraded.format_points_pair(change.before, shown)
    difference = _format_difference((shown or 0.0) - (change.before or 0.0))
    return MarkChangeRow(
        student=names.people.get(change.student, NOBODY),
        before=before,
        after=after,
        difference=difference,
        why=regraded.reason_sentences(change.differences, kind),
        notes=(*_change_notes(change), *((OVERRIDDEN_NOTE,) if change.student in names.overridden else ())),
        attempt="" if change.submission_id is None else f"/soumissions/{change.submission_id}",
    )


def _format_difference(difference: float) -> str:
    if abs(difference) < SAME_POINTS:
        return ""
    return f"{'+' if difference > 0 else '−'}{format_points(abs(difference))}"


def _change_notes(change: MarkChange) -> Iterator[str]:
    if change.waiting:
        yield f"{plural(change.waiting, 'copie attend', 'copies attendent')} encore"
    if change.failed:
        failed = plural(change.failed, "copie n’a pas pu être recorrigée", "copies n’ont pas pu être recorrigées")
        yield f"{failed} (incident de notre côté) : l’ancienne correction reste"
    if change.sent_since:
        sent = plural(change.sent_since, "essai envoyé", "essais envoyés")
        yield f"{sent} depuis : la version actuelle s’y applique déjà"
