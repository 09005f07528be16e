"""Students who hand in together: what one sends counts for both, by the dates and for the time that they were told."""

from __future__ import annotations

from datetime import datetime, timedelta
from random import Random
from typing import Any

import pytest

from server.assignments import team_repository, teams
from server.assignments.models import Assignment, Mode, TeamMember
from server.assignments.schemas import AssignmentInput, validate_assignment
from server.assignments.student_assignments import load_student_assignment
from server.assignments.team_rules import list_current_partners
from server.audit.models import AuditAction
from server.audit.repository import load_entries
from server.audit.schemas import AuditFilter
from server.base.errors import Conflict, Invalid, InvalidFields, NotFound, WrongMoment
from server.classes.models import ClassRole, Membership
from server.comments import service as comments
from server.comments.schemas import ThreadTarget
from server.course import Course
from server.database import Database, utc_now
from server.desk.rubrics.views import list_copies
from server.gradebook.service import find_attempt
from server.identity.models import Account
from server.marks import rubrics
from server.marks.loading import load_gradebook
from server.marks.rubric_items import RubricInput, RubricItem, RubricScores
from server.marks.service import load_visible_marks
from server.personal.team_copies import give_team_attempts_to_partners
from server.rights.service import ClassAccess, build_class_access
from tests.support.marks import AFTER, CLOSES, DAY, DUE, ODOMETRY, OPENS, POSES, Term

HOUR = timedelta(hours=1)


@pytest.fixture
def term(sqlite: Database) -> Term:
    return Term.begin(sqlite)


def pair_up(term: Term, assignment: Assignment, *students: Account, since: datetime = OPENS, **values: Any) -> None:
    """Put students into one team, from then on."""
    team = students[0].id
    with term.database.write() as db:
        for student in students:
            row = {"team_id": team, "account_id": student.id, "since": since, **values}
            db.add(TeamMember(assignment_id=assignment.id, **row))


def points(term: Term, course: Course, *students: Account, now: datetime = AFTER) -> list[float | None]:
    with term.database.read() as db:
        book = load_gradebook(db, course, term.made, now)
        by_id = {row.member.id: row.marks[0].points for row in book.rows}
        # One student alone is marked as in the whole class.
        for student in students:
            (row,) = load_gradebook(db, course, term.made, now, only=[student.id]).rows
            assert row.marks[0].points == by_id[student.id]
    return [by_id[student.id] for student in students]


def three(term: Term) -> tuple[Account, Account, Account]:
    return term.student("Ada", "Abel"), term.student("Blaise", "Bez"), term.student("Chloé", "Cros")


def test_what_one_sends_counts_for_both_and_stays_after_a_change(term: Term, course: Course) -> None:
    work = term.assignment(exercises={POSES: 1.0}, team_size=2)
    ada, blaise, chloe = three(term)
    term.send(ada, POSES, 4, OPENS + HOUR)  # before they hand in together
    pair_up(term, work, ada, blaise, since=OPENS + DAY, until=OPENS + 3 * DAY)
    assert points(term, course, ada, blaise, chloe, now=OPENS + 2 * DAY) == [4, None, None]
    term.send(blaise, POSES, 12, OPENS + 2 * DAY)
    pair_up(term, work, ada, chloe, since=OPENS + 3 * DAY)
    assert points(term, course, ada, blaise, chloe) == [12, 12, None]
    term.send(chloe, POSES, 20, OPENS + 4 * DAY)
    term.send(blaise, POSES, 16, OPENS + 4 * DAY)
    assert points(term, course, ada, blaise, chloe) == [20, 16, 20], "after the change, blaise hands in alone"


def test_a_pair_has_the_later_of_its_dates(term: Term, course: Course) -> None:
    """A date that one of them was granted holds for what either sends; being excused stays personal."""
    work = term.assignment(exercises={POSES: 1.0}, team_size=2, late="refuse", closes_at=None)
    ada, blaise, chloe = three(term)
    pair_up(term, work, ada, blaise)
    term.exempt(work, ada, due_at=DUE + 3 * DAY, extends=True, excused=None)
    term.send(blaise, POSES, 20, DUE + DAY)
    term.send(chloe, POSES, 20, DUE + DAY)
    assert points(term, course, ada, blaise, chloe) == [20, 20, None]
    with term.database.read() as db:
        own = load_student_assignment(db, work, blaise.id, (), DUE + DAY)
    assert own.rules.due_at == DUE + 3 * DAY
    assert [value.origin for value in own.rules.sources["due_at"]] == ["team", "assignment"]
    assert [partner.name for partner in own.partners] == ["Ada Abel"]
    term.exempt(work, blaise, excused=True)
    with term.database.read() as db:
        assert not load_student_assignment(db, work, ada.id, (), DUE).rules.excused


def test_teachers_form_teams_and_a_refusal_forms_none(term: Term) -> None:
    work, alone = term.assignment(team_size=2), term.assignment("DM 2")
    ada, blaise, chloe = three(term)
    stranger = Term.begin(term.database).student("Denis", "Dor")

    def form(*groups: list[Account], to: Assignment = work, **values: bool) -> None:
        with term.database.write() as db:
            ids = [[student.id for student in group] for group in groups]
            teams.form_teams(db, term.made, term.teacher.id, to, ids, **values)

    for refusal, groups, to in (
        (NotFound, [[ada, blaise]], alone),
        (Invalid, [[ada]], work),
        (Invalid, [[ada, ada]], work),
        (Invalid, [[ada, blaise, chloe]], work),
        (NotFound, [[ada, stranger]], work),
        (Conflict, [[ada, blaise], [chloe, blaise]], work),
    ):
        with pytest.raises(refusal):
            form(*groups, to=to)
    with term.database.read() as db:
        assert not team_repository.load_current_members(db, work.id)
    form([ada, blaise], earlier=True)
    with term.database.read() as db:
        (places,) = team_repository.load_team_places(db, [work.id]).values()
        assert {place.since for place in places} == {OPENS}, "what they had sent counts for both"
    with term.database.write() as db:
        teams.end_team(db, term.made, term.teacher.id, work, places[0].team_id)
        assert teams.form_random_teams(db, term.made, term.teacher.id, work, Random(1)) == 1
        assert len(team_repository.load_current_members(db, work.id)) == 2, "of three, one stays alone"
        log = [entry.what for entry in load_entries(db, term.made.id, AuditFilter(), limit=50)]
    assert log.count(AuditAction.team_formed) == 4
    assert log.count(AuditAction.team_ended) == 2


def test_students_agree_on_a_team_and_part(term: Term) -> None:
    now = utc_now()
    work = term.assignment(
        opens_at=now - DAY, due_at=now + DAY, closes_at=now + DAY, team_size=2, teams_by_students=True
    )
    ada, blaise, chloe = three(term)

    def act(what: str, one: Account, other: Account | None = None) -> None:
        with term.database.write() as db:
            if other is None:
                getattr(teams, what)(db, term.made, work, one.id)
            else:
                getattr(teams, what)(db, term.made, work, one.id, other.id)

    def partners(student: Account) -> list[str]:
        with term.database.read() as db:
            places = team_repository.load_team_places(db, [work.id]).get(work.id, ())
        return [place.name for place in list_current_partners(places, student.id)]

    act("propose_teammate", ada, blaise)
    act("propose_teammate", ada, blaise)  # a double click
    assert partners(ada) == [], "nobody hands in with somebody who has not agreed"
    with pytest.raises(NotFound):
        act("accept_proposal", chloe, ada)
    act("propose_teammate", blaise, ada)
    assert (partners(ada), partners(blaise)) == (["Blaise Bez"], ["Ada Abel"])
    act("propose_teammate", chloe, ada)
    with pytest.raises(Conflict):
        act("accept_proposal", ada, chloe)
    act("leave_team", ada)
    assert (partners(ada), partners(blaise)) == ([], [])
    act("accept_proposal", ada, chloe)
    assert partners(chloe) == ["Ada Abel"]
    with term.database.write() as db:
        row = db.merge(work)
        row.closes_at, row.due_at = now - HOUR, now - HOUR
    work.closes_at = work.due_at = now - HOUR
    with pytest.raises(WrongMoment):
        act("leave_team", chloe)
    work.teams_by_students = False
    with pytest.raises(Conflict):
        act("propose_teammate", blaise, ada)


def test_only_what_was_sent_together_is_shown(term: Term, course: Course) -> None:
    work = term.assignment(exercises={POSES: 1.0}, team_size=2)
    ada, blaise, chloe = three(term)
    pair_up(term, work, ada, blaise, since=OPENS + DAY)
    before, shared = term.send(ada, POSES, 4, OPENS + HOUR), term.send(ada, POSES, 12, OPENS + 2 * DAY)
    elsewhere = term.send(ada, ODOMETRY, 12, OPENS + 2 * DAY)
    with term.database.write() as db:
        assert find_attempt(db, blaise, shared).shared
        assert not find_attempt(db, ada, shared).shared
        for reader, attempt in ((blaise, before), (blaise, elsewhere), (chloe, shared)):
            with pytest.raises(NotFound):
                find_attempt(db, reader, attempt)
        with pytest.raises(Conflict):
            comments.begin_thread(db, blaise, find_attempt(db, blaise, shared), ThreadTarget(), "Bonjour", object())  # type: ignore[arg-type]


def test_a_partners_test_withholds_the_mark_and_the_attempt(term: Term, course: Course) -> None:
    """An attempt that a test holds back from its author is not told to a partner either."""
    work = term.assignment(exercises={POSES: 1.0}, team_size=2)
    ada, blaise, _ = three(term)
    pair_up(term, work, ada, blaise)
    test = term.assignment("Contrôle", exercises={POSES: 1.0}, mode=Mode.test, due_at=None, closes_at=None)
    term.sit(test, ada)
    sent = term.send(ada, POSES, 20, OPENS + DAY)
    with term.database.read() as db, pytest.raises(NotFound):
        find_attempt(db, blaise, sent)
    with term.database.read() as db:
        own = load_visible_marks(db, course, term.made, blaise.id, AFTER)
    assert all(mark.mark is None for mark in own.marks if mark.assignment.id == work.id)


def test_a_pair_is_one_copy_marked_by_hand(term: Term) -> None:
    work = term.assignment(exercises={POSES: 1.0}, team_size=2)
    ada, blaise, chloe = three(term)
    pair_up(term, work, ada, blaise)
    term.send(blaise, POSES, 12)
    item = RubricItem("a", "Clarté", 4.0, ())
    with term.database.write() as db:
        rubric = rubrics.save_rubric(db, term.made, term.teacher, work, RubricInput("À la main", 1.0, False, (item,)))
        _, column = rubrics.require_rubric(db, work)
        rows = list_copies(db, _access(term), work, rubric, column)
        assert sorted(row.name for row in rows)[-1] == "Chloé Cros"
        assert len(rows) == 2
        assert rows[0].sent, "a partner has sent something"
        both = RubricScores({"a": 3.0}, {"a": "bien"})
        rubrics.save_rubric_marking(db, term.made, term.teacher, work, rows[0].student, both, finish=True)
        markings = rubrics.repository.load_rubric_markings(db, rubric.column_id)
        assert {(student, row.points["a"]) for student, row in markings.items()} == {(ada.id, 3.0), (blaise.id, 3.0)}
    assert chloe.id not in markings


def _access(term: Term) -> ClassAccess:
    seat = Membership(class_id=term.made.id, account_id=term.teacher.id, role=ClassRole.teacher, status="active")
    return build_class_access(term.teacher, term.made, seat)


def test_what_an_erased_student_sent_for_both_stays_with_the_other(term: Term, course: Course) -> None:
    work = term.assignment(exercises={POSES: 1.0}, team_size=2)
    ada, blaise, _ = three(term)
    pair_up(term, work, ada, blaise, since=OPENS + DAY)
    alone, shared = term.send(ada, POSES, 4, OPENS + HOUR), term.send(ada, POSES, 20, OPENS + 2 * DAY)
    with term.database.write() as db:
        give_team_attempts_to_partners(db, ada.id)
    with term.database.read() as db:
        assert find_attempt(db, blaise, shared).submission.account_id == blaise.id
        assert find_attempt(db, ada, alone).submission.account_id == ada.id
    assert points(term, course, blaise) == [20]


@pytest.mark.parametrize("change", [{"team_size": 0}, {"team_size": 7}, {"team_size": 2, "mode": Mode.test}])
def test_a_test_is_sat_alone_and_teams_are_small(change: dict[str, Any]) -> None:
    fields = AssignmentInput("DM", (), OPENS, closes_at=CLOSES, **change)
    with pytest.raises(InvalidFields) as refused:
        validate_assignment(fields, {})
    assert "team_size" in refused.value.problems
