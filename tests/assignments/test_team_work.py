"""A student who has sent nothing: the pages say which partner has, with the mark that counts."""

from __future__ import annotations

from datetime import timedelta

import pytest

from server.assignments.models import Mode, TeamMember
from server.board.schemas import ProgressState
from server.board.service import load_board_inputs
from server.course import Course
from server.database import utc_now
from server.gradebook.team_work import find_teammate_attempt, load_teammate_attempts
from server.identity.models import Role
from tests.support.classes import person, seat
from tests.support.marks import AFTER, CLOSES, DAY, ODOMETRY, OPENS, POSES, Term
from tests.support.service import Site

HOUR = timedelta(hours=1)


@pytest.fixture
def term(site: Site) -> Term:
    return Term.begin(site.database, person(site, Role.teacher, "Mme Martin").account)


def test_pages_name_the_partner_who_has_sent(site: Site, term: Term, course: Course) -> None:
    ada, blaise = person(site), person(site)
    for student, name in ((ada, "Ada"), (blaise, "Blaise")):
        seat(site.database, term.made, student.account, given_name=name, family_name="Abel")
    now = utc_now()
    work = term.assignment(team_size=2, opens_at=now - 2 * DAY, due_at=now + DAY, closes_at=None)
    with site.database.write() as db:
        for student in (ada, blaise):
            row = {"team_id": ada.id, "account_id": student.id, "since": now - DAY}
            db.add(TeamMember(assignment_id=work.id, **row))
    term.send(ada.account, ODOMETRY, 20, now - 2 * DAY)  # before they hand in together
    with site.database.read() as db:
        before = load_board_inputs(db, course, term.made, now)
    assert before.board.cells_by_pair[blaise.id, POSES].state is ProgressState.none
    sent = term.send(ada.account, POSES, 12, now - HOUR)
    with site.database.read() as db:
        inputs = load_board_inputs(db, course, term.made, now)
    cell = inputs.board.cells_by_pair[blaise.id, POSES]
    assert (cell.points, cell.attempts, cell.state, cell.partner) == (12, 0, ProgressState.trying, "Ada Abel")
    assert inputs.board.cells_by_pair[ada.id, POSES].partner == ""
    assert inputs.board.cells_by_pair[blaise.id, ODOMETRY].state is ProgressState.none
    assert inputs.version != before.version
    assert inputs.board.counts.started == 2

    teacher = person(site, account=term.teacher).browser(site)
    pages = [
        (teacher, f"/classes/{term.made.id}/tableau", "rendu par Ada Abel"),
        (teacher, f"/classes/{term.made.id}/eleves/{blaise.id}", "rendu par Ada Abel"),
        (teacher, f"/classes/{term.made.id}/eleves/{blaise.id}/{POSES}", "Rendu par Ada Abel"),
        (blaise.browser(site), "/l20/exercices/poses/essais", "Rendu par Ada Abel"),
    ]
    for browser, path, words in pages:
        answer = browser.get(path)
        assert answer.status_code == 200, path
        assert words in answer.text, path
        assert "12" in answer.text, path
    assert f"/soumissions/{sent}" in pages[-1][0].get(pages[-1][1]).text


def test_the_attempt_is_the_one_that_the_assignment_takes(term: Term) -> None:
    ada, blaise = term.student("Ada", "Abel"), term.student("Blaise", "Bez")
    for counts, exercise, expected in (("best", POSES, 0.8), ("last", ODOMETRY, 0.4)):
        work = term.assignment(exercises={exercise: 1.0}, team_size=2, counts=counts)
        with term.database.write() as db:
            for student in (ada, blaise):
                row = {"team_id": work.id, "account_id": student.id, "since": OPENS, "until": CLOSES}
                db.add(TeamMember(assignment_id=work.id, **row))
        for points, at in ((16, OPENS + HOUR), (8, OPENS + DAY), (20, AFTER)):
            term.send(ada, exercise, points, at)
        with term.database.read() as db:
            read = load_teammate_attempts(db, [blaise.id], exercise=exercise)[blaise.id, exercise]
            assert (read.score, read.partner) == (expected, "Ada Abel")
            assert not load_teammate_attempts(db, [blaise.id], until=OPENS)


def test_what_a_test_withholds_is_not_told_to_the_partner(term: Term) -> None:
    ada, blaise = term.student("Ada", "Abel"), term.student("Blaise", "Bez")
    work = term.assignment(exercises={POSES: 1.0}, team_size=2)
    with term.database.write() as db:
        for student in (ada, blaise):
            db.add(TeamMember(assignment_id=work.id, team_id=work.id, account_id=student.id, since=OPENS))
    term.send(ada, POSES, 20, OPENS + DAY)
    with term.database.read() as db:
        assert find_teammate_attempt(db, blaise, POSES) is not None
    term.sit(term.assignment("Contrôle", exercises={POSES: 1.0}, mode=Mode.test, due_at=None, closes_at=None), ada)
    with term.database.read() as db:
        assert find_teammate_attempt(db, blaise, POSES) is None
        assert find_teammate_attempt(db, None, POSES) is None
