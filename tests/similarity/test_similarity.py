"""Codes that look alike: disguises are seen through, what the course gives is nobody's, short exercises are refused."""

from __future__ import annotations

import json
import re
from dataclasses import dataclass
from datetime import timedelta
from uuid import UUID, uuid4

import pytest

from graders.core.contract.findings import Judgement
from server.assignments.models import AssignedExercise, Assignment
from server.base.errors import Invalid, Overloaded
from server.classes.models import SchoolClass, Status
from server.course import Course
from server.database import utc_now
from server.gradebook import service as gradebook
from server.gradebook.schemas import GradingResult
from server.identity.models import Role
from server.similarity import compare, service
from server.similarity.service import ComparedCopy, CopyComparison
from server.submissions.models import Submission
from tests.support.classes import Person, new_class, person, seat
from tests.support.service import Site, fake_verdict, new_account

LONG, SHORT = "l20/slam_graphe", "l20/reechantillonnage"


def specimen(course: Course, name: str) -> str:
    path = course.exercises[LONG].grader.folder / "specimens" / "ok" / name
    return str(path.read_text(encoding="utf-8"))


def disguised(code: str) -> str:
    """Other names for what is assigned and for loops' variables, comments, and blank lines."""
    names = set(re.findall(r"^ +([a-z_]{1,12}) = ", code, re.MULTILINE)) | set(re.findall(r"for (\w+) in", code))
    for number, name in enumerate(sorted(names)):
        code = re.sub(rf"\b{name}\b", f"autre_{number}", code)
    return "\n\n".join(f"{line}  # {number}" for number, line in enumerate(code.split("\n")))


def copy_of(code: str) -> ComparedCopy:
    return ComparedCopy(uuid4(), uuid4(), code)


def own(course: Course) -> tuple[str, str, str]:
    """Three right programs of the course's, as if it did not know them, of different hands."""
    first, second, third = (
        specimen(course, name) for name in ("variete.py", "python_pur.py", "scipy_least_squares.py")
    )
    return first, second, third


def test_a_copy_is_seen_under_other_names_and_a_different_hand_is_not(course: Course) -> None:
    first, second, third = own(course)
    found = list(
        compare.find_matching_pairs([first, second, disguised(first), third], [course.exercises[LONG].starter])
    )
    assert [(pair.first, pair.second) for pair in found] == [(0, 2)]
    pair = found[0]
    assert min(pair.shares) > 0.9
    assert len(pair.lines[0]) > 10
    assert max(pair.lines[0]) <= first.count("\n") + 1
    assert max(pair.lines[1]) <= disguised(first).count("\n") + 1


def test_what_the_course_gives_is_nobody_s(course: Course) -> None:
    """Two students who send the course's own code share nothing of their own."""
    first = own(course)[0]
    assert list(compare.find_matching_pairs([first, first], [first])) == []
    known = compare.collect_gram_hashes([first])
    assert compare.own_code_length(first, known) == 0
    assert compare.own_code_length(first, ()) > compare.MIN_CODE_LENGTH


def test_pairs_are_found_and_short_exercises_are_refused(course: Course, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        service, "_run_comparison", lambda question: compare.compare_codes_of_request(json.loads(question))
    )
    first = own(course)[0]
    mine = first.replace("def ", "def moi_") + "\n".join(f"x{n} = {n} ** {n % 7} + y{n}" for n in range(60))
    sent = [copy_of(mine), copy_of(disguised(mine)), copy_of("x = 1\n")]
    found = service.compare_copies(course, course.exercises[LONG], sent)
    assert (found.compared, found.too_short) == (3, False)
    assert [(pair.first, pair.second) for pair in found.pairs] == [(sent[0], sent[1])]
    short = service.compare_copies(course, course.exercises[SHORT], sent)
    assert (short.too_short, short.pairs) == (True, ())


def test_one_comparison_at_a_time_and_its_failure_is_told(course: Course, monkeypatch: pytest.MonkeyPatch) -> None:
    with service._comparing, pytest.raises(Overloaded):
        service.compare_copies(course, course.exercises[LONG], [])
    monkeypatch.setattr(service.sys, "executable", "/bin/false")
    with pytest.raises(Invalid, match="n’ont pas pu être comparées"):
        service.compare_copies(course, course.exercises[LONG], [copy_of("x = 1")])
    assert service._comparing.acquire(blocking=False), "the next one may begin"
    service._comparing.release()


@dataclass(frozen=True)
class Classroom:
    site: Site
    teacher: Person
    made: SchoolClass
    assignment: UUID

    def send(self, student: Person, code: str, *, score: bool = True, days: int = 0) -> None:
        with self.site.database.write() as db:
            at = utc_now() + timedelta(days=days)
            row = Submission(
                account_id=student.id, exercise=LONG, source=code.encode(), digest="d", seed=1, created_at=at
            )
            db.add(row)
            db.flush()
            outcome = "" if score else "# outcome: wrong_answer"
            gradebook.record_grading(db, row.id, GradingResult(Judgement(fake_verdict(outcome, 1)), at))

    def codes(self, course: Course, exercise: str = LONG) -> dict[UUID, str]:
        with self.site.database.read() as db:
            found = service.load_best_copies(db, db.get_one(Assignment, self.assignment), course.exercises[exercise])
        return {one.student: one.code for one in found}

    @property
    def href(self) -> str:
        return f"/classes/{self.made.id}/devoirs/{self.assignment}/ressemblances"


@pytest.fixture
def classroom(site: Site) -> Classroom:
    teacher = person(site, Role.teacher, "Mme Martin")
    made = new_class(site.database, teacher.account)
    with site.database.write() as db:
        opened, closes = utc_now() - timedelta(days=2), utc_now() + timedelta(days=2)
        row = Assignment(class_id=made.id, title="DM <1>", opens_at=opened, closes_at=closes)
        db.add(row)
        db.flush()
        for place, exercise in enumerate((LONG, SHORT, "l20/calcul_kabsch")):
            db.add(AssignedExercise(assignment_id=row.id, exercise=exercise, position=place))
    return Classroom(site, teacher, made, row.id)


def test_each_student_s_best_code_while_the_assignment_was_open(classroom: Classroom, course: Course) -> None:
    ada, bob, gone = (person(classroom.site, name=name) for name in ("Ada", "Bob", "Parti"))
    for one in (ada, bob):
        seat(classroom.site.database, classroom.made, one.account)
    seat(classroom.site.database, classroom.made, gone.account, status=Status.left)
    classroom.send(ada, "avant", days=-3)
    classroom.send(ada, "juste")
    classroom.send(ada, "faux ensuite", score=False)
    classroom.send(bob, "premier", score=False)
    classroom.send(bob, "dernier", score=False)
    classroom.send(bob, "après la fin", days=3)
    classroom.send(gone, "parti")
    classroom.send(classroom.teacher, "de l’enseignante")
    assert classroom.codes(course) == {ada.id: "juste", bob.id: "dernier"}
    with pytest.raises(Invalid, match="ne demande pas de code"):
        classroom.codes(course, "l20/calcul_kabsch")


def test_the_page_asks_a_question(classroom: Classroom, course: Course, monkeypatch: pytest.MonkeyPatch) -> None:
    code = own(course)[0].replace("def ", "def moi_") + "\n".join(f"x{n} = {n} ** {n % 7}" for n in range(90))
    for name in ("Ada <b>", "Bob"):
        one = person(classroom.site, name=name)
        seat(classroom.site.database, classroom.made, one.account)
        classroom.send(one, code)
    browser = classroom.teacher.browser(classroom.site)
    first = browser.get(classroom.href)
    assert "une question à poser" in " ".join(first.text.split())
    assert "calcul_kabsch" not in first.text
    compared = browser.get(f"{classroom.href}?exercice={LONG}").text
    assert "Ada &lt;b&gt;" in compared
    assert 'class="code-line shared"' in compared
    assert "2 copies comparées, 1 paire à regarder" in compared
    monkeypatch.setattr(service, "compare_copies", lambda *_: CopyComparison(2, too_short=True, pairs=()))
    assert "trop court" in browser.get(f"{classroom.href}?exercice={SHORT}").text
    assert browser.get(f"{classroom.href}?exercice=l20/poses").status_code == 404
    pupil = person(classroom.site)
    seat(classroom.site.database, classroom.made, pupil.account)
    assert pupil.browser(classroom.site).get(classroom.href).status_code == 403


def test_an_exercise_without_code_or_a_stranger(classroom: Classroom) -> None:
    stranger = person(classroom.site, account=new_account(classroom.site.database, Role.teacher))
    assert stranger.browser(classroom.site).get(classroom.href).status_code == 404
