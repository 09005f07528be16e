"""The lesson of a class: begun, changed and ended, its page, its stream, and what may be projected of it."""

from __future__ import annotations

import html
import json
import re
from collections.abc import Sequence
from datetime import timedelta
from itertools import pairwise
from uuid import UUID

import pytest
from sqlalchemy import select, update

from server.assignments.models import Mode, Visibility
from server.base import school_time
from server.base.app_services import get_service
from server.base.errors import Conflict, Invalid
from server.board.lesson_loading import propose_lesson_exercises
from server.board.lesson_state import find_lesson_mistakes
from server.board.live import LiveClassViews
from server.board.service import load_class_progress
from server.board.stuck import LessonExercises
from server.classes.models import Membership, SchoolClass
from server.classes.presence import PresenceRecorder
from server.course import Course
from server.database import Database, utc_now
from server.desk.lesson.live import LESSON
from server.identity.models import Account, Role
from server.lesson import repository, service
from server.lesson.models import Afterwards
from server.lesson.service import LONGEST_LESSON, LessonPlan
from server.web.words import DAYS
from tests.desk.test_classes import text_of
from tests.support.classes import Person, assign, new_class, person, seat
from tests.support.counting import Counted
from tests.support.crowd import Sent, seated, store
from tests.support.service import EXERCISE, Site, new_account
from tests.support.streams import parts_of

OTHER, THIRD = "l20/kabsch", "l20/predire2d"
WRONG = "rotation_oubliee"
RIGHT_CODE = "def composer(a, b):\n    x = a + b\n    return x\n"
WRONG_CODE = "def composer(a, b):\n    # Ada Lovelace\n    x = a - b\n    return x\n"


@pytest.fixture
def martin(site: Site) -> Person:
    return person(site, Role.teacher, "Mme Martin")


@pytest.fixture
def made(site: Site, martin: Person) -> SchoolClass:
    return new_class(site.database, martin.account)


def begin(database: Database, course: Course, made: SchoolClass, by: Account, *exercises: str) -> None:
    with database.write() as db:
        service.start_lesson(db, course, made, by.id, LessonPlan(exercises), utc_now())


def refuse(database: Database, course: Course, made: SchoolClass, by: Account, plan: LessonPlan) -> str:
    with database.write() as db, pytest.raises((Invalid, Conflict)) as refused:
        service.start_lesson(db, course, made, by.id, plan, utc_now())
    return str(refused.value.detail)


def test_a_lesson_has_one_to_four_open_exercises(database: Database, course: Course) -> None:
    teacher = new_account(database, Role.teacher)
    made = new_class(database, teacher)
    assign(database, made, EXERCISE, OTHER)
    assign(database, made, THIRD, mode=Mode.test)
    assert "d’un à 4" in refuse(database, course, made, teacher, LessonPlan(()))
    assert "n’est pas un exercice ouvert" in refuse(database, course, made, teacher, LessonPlan((THIRD,))), (
        "a test holds it"
    )
    no_challenge = LessonPlan((EXERCISE,), Afterwards.challenge)
    assert "Choisissez l’exercice à proposer" in refuse(database, course, made, teacher, no_challenge)
    begin(database, course, made, teacher, EXERCISE, OTHER, EXERCISE)
    assert "déjà en cours" in refuse(database, course, made, teacher, LessonPlan((EXERCISE,)))
    with database.read() as db:
        lesson = service.find_current_lesson(db, made.id, utc_now())
        assert lesson is not None
        assert lesson.exercises == [EXERCISE, OTHER]
        assert service.find_current_lesson(db, made.id, utc_now() + LONGEST_LESSON) is None, "nobody ended it"
    with database.write() as db:
        service.change_lesson(
            db, course, made, teacher.id, LessonPlan((OTHER,), Afterwards.challenge, EXERCISE), utc_now()
        )
        ended = service.end_lesson(db, made, teacher.id, utc_now())
        assert (ended.exercises, ended.next_step, ended.challenge) == ([OTHER], "challenge", EXERCISE)
    with database.read() as db:
        assert service.find_current_lesson(db, made.id, utc_now()) is None
        assert [row.id for row in repository.load_lessons(db, made.id)] == [ended.id]


def test_exercises_of_open_assignments_are_proposed(sqlite: Database, course: Course) -> None:
    made = new_class(sqlite, new_account(sqlite, Role.teacher))
    students = seated(sqlite, made, 4)
    assign(sqlite, made, EXERCISE, opened=timedelta(days=9), closes_at=utc_now() - timedelta(days=1))
    assign(sqlite, made, OTHER, THIRD, opened=timedelta(hours=1))
    store(sqlite, [Sent(student, OTHER, utc_now(), 1.0) for student in students[:3]])
    with sqlite.read() as db:
        available = service.list_available_exercises(db, course, made, utc_now())
        assert list(available) == [OTHER, THIRD, EXERCISE], "what is open comes first"
        progress = load_class_progress(db, course, made, utc_now())
        assert propose_lesson_exercises(progress, available) == (THIRD, EXERCISE), "most have solved the other one"


def test_a_mistake_counts_whoever_still_makes_it_and_those_that_all_have_corrected_come_last(
    sqlite: Database, course: Course
) -> None:
    made = new_class(sqlite, new_account(sqlite, Role.teacher))
    first, second, silent, elsewhere = seated(sqlite, made, 4)
    long_ago, now, later = (utc_now() - timedelta(minutes=minutes) for minutes in (50, 5, 2))
    overcome = [Sent(student, EXERCISE, now, 0.25, WRONG) for student in (first, second)]
    right = [Sent(student, EXERCISE, later, 1.0) for student in (first, second)]
    held = [Sent(silent, OTHER, long_ago, 0.25, "vt_pour_v"), Sent(elsewhere, THIRD, long_ago, 0.25, "ordre_matrices")]
    store(sqlite, [*overcome, *right, *held])
    with sqlite.read() as db:
        progress = load_class_progress(db, course, made, utc_now())
    mistakes = find_lesson_mistakes(progress, LessonExercises((EXERCISE, OTHER), long_ago + timedelta(minutes=1)))
    assert [(row.id, row.still, row.made) for row in mistakes] == [("vt_pour_v", (silent,), 1), (WRONG, (), 2)]


def stuck_students(site: Site, made: SchoolClass, count: int) -> Sequence[UUID]:
    """Has so many students be stuck on the same mistake, and one more solve the exercise after it."""
    now = utc_now()
    students = seated(site.database, made, count + 1, now)
    sent = [
        Sent(student, EXERCISE, now - timedelta(minutes=10 - 4 * turn), 0.25, WRONG, WRONG_CODE + f"y = {turn}\n")
        for student in students[:count]
        for turn in range(3)
    ]
    helper = students[count]
    sent += [
        Sent(helper, EXERCISE, now - timedelta(minutes=9), 0.25, WRONG, WRONG_CODE),
        Sent(helper, EXERCISE, now - timedelta(minutes=5), 1.0, None, RIGHT_CODE),
    ]
    store(site.database, sent)
    return students


def words_of(markup: str) -> str:
    """Return what a part of a page shows."""
    return " ".join(html.unescape(re.sub("<[^>]+>", " ", markup)).replace("\u00a0", " ").split())


def test_a_row_says_who_was_seen_who_is_silent_and_who_can_help(
    site: Site, course: Course, martin: Person, made: SchoolClass
) -> None:
    now = utc_now()
    seen, silent, unseen, helper = seated(site.database, made, 4, now)
    sent = [
        Sent(student, EXERCISE, now - timedelta(minutes=minutes), 0.25, mistake, f"x = {minutes}\n")
        for student, all_minutes, mistake in (
            (seen, (30, 20, 2), WRONG),
            (silent, (25, 10), None),
            (unseen, (20, 10, 1), WRONG),
        )
        for minutes in all_minutes
    ]
    store(site.database, [*sent, Sent(helper, EXERCISE, now - timedelta(minutes=9), 1.0)])
    with site.database.write() as db:
        plan = LessonPlan((EXERCISE,), Afterwards.help)
        service.start_lesson(db, course, made, martin.account.id, plan, now - timedelta(minutes=35))
        service.record_student_visit(db, made, martin.account.id, seen, EXERCISE, now - timedelta(minutes=5))
    page, rows = f"/classes/{made.id}/seance", []
    for _ in range(2):
        rows.append(
            [words_of(row) for row in text_of(martin.browser(site), page).split("<li class=")[1:] if "data-key" in row]
        )
        with site.database.write() as db:
            service.record_student_visit(db, made, martin.account.id, seen, EXERCISE, now - timedelta(minutes=12))
    (first, second, last), later = rows[0][:3], rows[1][0]
    assert "25 min Échoue : « Première »" in first, "a mistake without a name by what fails"
    assert "2 essais ratés, rien envoyé depuis 10 min" in first
    assert "Peut l’aider : Edsger Lovelace" in first
    assert "rien envoyé" not in second
    assert "Peut l’aider : Edsger Lovelace , après avoir aidé Alan Lovelace" in second
    assert "Vu il y a 5 min par Mme Martin" in last
    assert "Peut l’aider" not in last
    assert "Vu il y a 12 min par Mme Martin" in later, "first again, and said still"


def test_the_page_names_who_is_stuck_and_on_what(site: Site, course: Course, martin: Person, made: SchoolClass) -> None:
    browser, href = martin.browser(site), f"/classes/{made.id}"
    students = stuck_students(site, made, 6)
    start = text_of(browser, f"{href}/seance")
    assert "Commencer la séance" in start
    sent = browser.post(f"{href}/seance", data={"action": "commencer", "exercice": [EXERCISE], "suite": "help"})
    assert (sent.status_code, sent.headers["location"]) == (303, f"{href}/seance")
    answer = browser.get(href)
    assert (answer.status_code, answer.headers["location"]) == (303, f"{href}/seance"), "the class's first page"
    assert "Avancement" in text_of(browser, f"{href}/tableau") or "matrix" in text_of(browser, f"{href}/tableau")
    text = text_of(browser, f"{href}/seance")
    rows = text.split('class="stuck-row"')[1:]
    assert len(rows) == 5, "the most urgent, and the others by name"
    assert "Et aussi" in rows[-1]
    said = words_of(rows[0])
    assert "sur l’exercice depuis 10 min" in said, "not on the mistake, which may be more recent"
    assert said.index("La rotation est oubliée") < said.index("3 essais ratés"), "on what, before how often"
    assert "Vu il y a" not in said
    assert "Dernier changement, ligne 5 : y = 1 devient y = 2" in said
    assert "Peut l’aider" in rows[0], "who has finished, after the same mistake"
    mistakes = text.split('class="mistake-row"')
    assert len(mistakes) == 2
    assert '<strong class="mistake-count">6</strong>' in mistakes[1]
    assert "10\N{NO-BREAK SPACE}min" not in mistakes[1], (
        "how long somebody is stuck is not how long they make a mistake"
    )
    assert f"{href}/erreurs/{EXERCISE}/{WRONG}/projeter" in mistakes[1]
    assert f"{href}/reprise?exercice={EXERCISE.replace('/', '%2F')}&amp;eleve=" in mistakes[1], "to those who have it"
    seen = re.findall(r'name="eleve" value="([^"]+)"', text)
    assert browser.post(f"{href}/seance", data={"action": "vu", "eleve": seen[0]}).status_code == 303
    again = text_of(browser, f"{href}/seance")
    order = re.findall(r'name="eleve" value="([^"]+)"', again)
    assert seen[0] not in order[:-1], "who was just seen stands below who was not"
    assert 'Élèves bloqués <span class="count tone-bad">6<' in again, "but is stuck still"
    wall = text_of(browser, f"{href}/seance/projeter")
    assert not re.search("Ada|Alan|Grace|Lovelace|" + "|".join(map(str, students)), wall), "no name on the projector"
    assert "1 sur 7" in wall
    refused = browser.post(f"{href}/seance", data={"action": "modifier"})
    assert refused.status_code == 422
    assert "Choisissez d’un à 4 exercices" in refused.text
    assert browser.post(f"{href}/seance", data={"action": "terminer"}).status_code == 303
    assert "Commencer la séance" in text_of(browser, f"{href}/seance")
    assert browser.get(href).status_code == 200, "the board again"


def test_the_stream_sends_the_parts_and_the_end(site: Site, course: Course, martin: Person, made: SchoolClass) -> None:
    stuck_students(site, made, 1)
    begin(site.database, course, made, martin.account, EXERCISE)
    get_service(site.app, LiveClassViews).max_stream_seconds = 0.0
    browser, path = martin.browser(site), f"/classes/{made.id}/seance/evenements"
    parts = parts_of(browser.get(path).text)
    assert parts.keys() == {"clock", "tabs", "days", "stuck", "mistakes", "finished"}
    assert "Bloqués 1" in parts["tabs"]
    assert "Erreurs 1, finis" in parts["tabs"]
    assert "stuck-row" in parts["stuck"]
    wall = parts_of(browser.get(path, params={"mur": "oui"}).text)
    assert wall.keys() == {"wall"}
    assert "Ada" not in json.dumps(wall)
    with site.database.write() as db:
        service.end_lesson(db, made, martin.account.id, utc_now())
    assert browser.get(path).text.startswith("event: ended\n")


def test_a_lesson_is_read_again_where_it_has_changed(
    site: Site, course: Course, martin: Person, made: SchoolClass
) -> None:
    """Whatever its page shows is in its pulse, but for what time alone changes."""
    student = stuck_students(site, made, 1)[0]
    begin(site.database, course, made, martin.account, EXERCISE)
    pulses = []

    def look() -> None:
        with site.database.read() as db:
            pulses.append(LESSON.load_pulse(db, made.id))

    look()
    with site.database.write() as db:
        service.record_student_visit(db, made, martin.account.id, student, EXERCISE, utc_now())
    look()
    with site.database.write() as db:
        service.change_lesson(db, course, made, martin.account.id, LessonPlan((EXERCISE,), Afterwards.help), utc_now())
    look()
    store(site.database, [Sent(student, EXERCISE, utc_now(), 1.0)])
    look()
    with site.database.write() as db:
        service.end_lesson(db, made, martin.account.id, utc_now())
    look()
    assert all(before != after for before, after in pairwise(pulses))


def test_the_page_says_how_many_mistakes_it_leaves_out(
    site: Site, course: Course, martin: Person, made: SchoolClass
) -> None:
    mistakes = (WRONG, "vt_pour_v", "ordre_matrices", "degres", "signe")
    students = seated(site.database, made, len(mistakes), utc_now())
    store(
        site.database,
        [
            Sent(student, EXERCISE, utc_now(), 0.25, mistake)
            for student, mistake in zip(students, mistakes, strict=True)
        ],
    )
    begin(site.database, course, made, martin.account, EXERCISE)
    text = text_of(martin.browser(site), f"/classes/{made.id}/seance")
    assert "Erreurs en cours les 3 plus fréquentes sur 5" in words_of(text)
    assert "Erreurs 3 sur 5, finis 0" in text, "on the tab of a phone too"
    assert text.count("à l’élève qui fait encore cette erreur. La page suivante demande") == 3


def test_a_page_takes_as_many_queries_for_many_as_for_few(site: Site, martin: Person, course: Course) -> None:
    counts = []
    for size in (2, 9):
        made = new_class(site.database, martin.account)
        stuck_students(site, made, size)
        begin(site.database, course, made, martin.account, EXERCISE)
        browser = martin.browser(site)
        text_of(browser, f"/classes/{made.id}/seance")
        with Counted(site.database) as counted:
            text_of(browser, f"/classes/{made.id}/seance")
        counts.append(len(counted.statements))
    assert counts[0] == counts[1]


@pytest.mark.parametrize(
    ("held", "shown"),
    [
        ({}, (True, True)),
        ({"solution": Visibility.never}, (True, False)),
        ({"diagnosis": Visibility.never}, (False, False)),
        ({"mode": Mode.test}, (False, False)),
        ({"mode": Mode.test, "released_at": utc_now()}, (True, True)),
    ],
    ids=["open", "solution held", "diagnosis held", "test", "released test"],
)
def test_nothing_held_is_projected(
    site: Site, martin: Person, made: SchoolClass, held: dict[str, object], shown: tuple[bool, bool]
) -> None:
    stuck_students(site, made, 6)
    assign(site.database, made, EXERCISE, **held)
    text = text_of(martin.browser(site), f"/classes/{made.id}/erreurs/{EXERCISE}/{WRONG}/projeter")
    assert ("x = a <" in text or "x <span" in text or "ne peut pas être projetée" not in text) is shown[0]
    assert ("Ce programme est faux" in text, "Ce programme est juste" in text) == shown
    assert not re.search("Ada|Lovelace|Hopper", text)


def test_those_of_a_lesson_are_not_guessed_among_those_of_before(
    site: Site, course: Course, martin: Person, made: SchoolClass
) -> None:
    now, page = utc_now(), f"/classes/{made.id}/seance"
    students, (absent,) = seated(site.database, made, 6, now), seated(site.database, made, 1)
    before = [Sent(student, EXERCISE, now - timedelta(minutes=50), 0.25, WRONG, WRONG_CODE) for student in students]
    solved = [Sent(student, EXERCISE, now - timedelta(minutes=40), 1.0, None, RIGHT_CODE) for student in students]
    at_home = Sent(absent, EXERCISE, now - timedelta(days=3), 1.0)
    store(site.database, [*before, *solved[:4], at_home, Sent(students[0], EXERCISE, now, 0.25, WRONG, WRONG_CODE)])
    with site.database.write() as db:
        plan, begun = LessonPlan((EXERCISE,)), now - timedelta(minutes=30)
        service.start_lesson(db, course, made, martin.account.id, plan, begun)
    browser, project = martin.browser(site), f"/classes/{made.id}/erreurs/{EXERCISE}/{WRONG}/projeter"
    row = words_of(text_of(browser, page).split('class="mistake-row"')[1])
    assert "3 élèves ont fait cette erreur, 3 la font encore" in row
    assert "À projeter à partir de 5 élèves, pour que personne ne soit reconnu" in row
    assert project not in text_of(browser, page)
    text = text_of(browser, project)
    assert "Moins de 5 élèves ont fait cette erreur pendant la séance" in text
    assert "Ce programme est faux" not in text
    assert "4 sur 6" in text_of(browser, f"{page}/projeter"), "who is absent does not count"
    store(site.database, [Sent(student, EXERCISE, now, 0.25, WRONG, WRONG_CODE) for student in students[1:3]])
    row = words_of(text_of(browser, page).split('class="mistake-row"')[1])
    assert "5 élèves ont fait cette erreur, 5 la font encore" in row
    assert "Projeté sans les noms" in row
    assert "Ce programme est faux" in text_of(browser, project)


def test_only_staff_run_a_lesson(site: Site, course: Course, martin: Person, made: SchoolClass) -> None:
    student, stranger = person(site), person(site, Role.teacher, "Autre")
    seat(site.database, made, student.account)
    begin(site.database, course, made, martin.account, EXERCISE)
    for path in ("seance", "seance/projeter", "seance/evenements", "tableau"):
        assert text_of(student.browser(site), f"/classes/{made.id}/{path}", 403)
        assert text_of(stranger.browser(site), f"/classes/{made.id}/{path}", 404)
    assert student.browser(site).post(f"/classes/{made.id}/seance", data={"action": "terminer"}).status_code == 403
    assert student.browser(site).get(f"/classes/{made.id}").status_code == 200, "a student's own page"


def test_who_works_without_opening_a_page_is_present(site: Site, made: SchoolClass) -> None:
    student = person(site)
    seat(site.database, made, student.account)
    page = text_of(student.browser(site), "/compte")
    (address,) = re.findall(r'data-presence="([^"]+)"', page)
    with site.database.write() as db:
        db.execute(update(Membership).values(last_seen_at=None))
    get_service(site.app, PresenceRecorder)._recent.clear()
    assert student.browser(site).get(address).status_code == 204
    with site.database.read() as db:
        assert db.execute(select(Membership.last_seen_at).where(Membership.account_id == student.id)).scalar_one()
    site.client.cookies.clear()
    assert site.client.get(address).status_code == 401


def test_the_review_of_a_lesson_says_whom_to_see_and_what_to_explain(
    site: Site, course: Course, martin: Person, made: SchoolClass
) -> None:
    browser, href = martin.browser(site), f"/classes/{made.id}"
    students = stuck_students(site, made, 6)
    now = utc_now()
    idle, absent = seated(site.database, made, 1, now)[0], seated(site.database, made, 1)[0]
    failing = seated(site.database, made, 4, now)
    store(site.database, [Sent(student, EXERCISE, now - timedelta(minutes=2), 0.1) for student in failing])
    with site.database.write() as db:
        plan = LessonPlan((EXERCISE,))
        lesson = service.start_lesson(db, course, made, martin.account.id, plan, now - timedelta(minutes=30))
    ended = browser.post(f"{href}/seance", data={"action": "terminer"})
    assert ended.headers["location"] == f"{href}/seance/{lesson.id}"
    text = text_of(browser, f"{href}/seance/{lesson.id}")
    parts = {
        name: re.split("</section>|</details>", text.split(f'id="{name}"')[1])[0]
        for name in ("voir", "expliquer", "enonces", "rien", "progres")
    }
    assert all(f"/eleves/{student}/{EXERCISE}" in parts["voir"] for student in students[:6])
    assert "3 essais ratés sans progrès les 10 dernières minutes" in parts["voir"]
    assert "6 élèves" in parts["expliquer"]
    for lead in (f"/erreurs/{EXERCISE}/{WRONG}/projeter", "/soumissions/", "/mots?exercice=", "Relire «"):
        assert lead in parts["expliquer"], "each line leads to its doing"
    assert "1 sur 11 ont réussi" in parts["enonces"]
    assert "4 échouent pour une raison non identifiée" in parts["enonces"]
    present, unseen = parts["rien"].split("Non connectés")
    assert str(idle) in present
    assert str(absent) in unseen
    assert parts["progres"].count("<li>") == 1
    week = text_of(browser, f"{href}/semaine")
    assert 'id="expliquer"' in week
    assert 'id="voir"' not in week, "three failures in a lesson are too few for a week"
    assert "déjà signalé" not in text
    assert f"{href}/seance/{lesson.id}" in text_of(browser, f"{href}/seance")
    other = new_class(site.database, martin.account)
    assert text_of(browser, f"/classes/{other.id}/seance/{lesson.id}", 404)
    assert text_of(browser, f"/classes/{other.id}/semaine", 200)
    with site.database.write() as db:
        begun = now - timedelta(minutes=20)
        again = service.start_lesson(db, course, made, martin.account.id, plan, begun)
    day = school_time.to_local(lesson.started_at)
    told = text_of(browser, f"{href}/seance/{again.id}").split('id="voir"')[1].split("</section>")[0]
    assert told.count(f"déjà signalé {DAYS[day.weekday()]} ") == 6


def test_a_function_that_is_right_is_not_projected_as_wrong(site: Site, martin: Person, made: SchoolClass) -> None:
    """The mistake is in the second function: the first stands in right programs too."""
    now = utc_now()
    students = seated(site.database, made, 6)
    first = "def composer(a, b):\n    return a + b\n\n"
    wrong, right = (f"{first}def relatif(a, b):\n    return {text}\n" for text in ("a - b", "b - a"))
    store(
        site.database,
        [
            *(Sent(student, EXERCISE, now - timedelta(minutes=3), 0.2, WRONG, wrong) for student in students[:5]),
            Sent(students[5], EXERCISE, now, 1.0, None, right),
        ],
    )
    text = text_of(martin.browser(site), f"/classes/{made.id}/erreurs/{EXERCISE}/{WRONG}/projeter")
    extracts = text.split('class="projection-extracts"')[1].split("</div>")[0]
    assert "composer" not in extracts
    assert extracts.count("relatif") == 2
    assert ('class="line-wrong"' in extracts, 'class="line-right"' in extracts) == (True, True)


def test_a_student_sees_the_exercises_of_the_day_and_what_comes_next(
    site: Site, course: Course, martin: Person, made: SchoolClass
) -> None:
    ada = person(site)
    seat(site.database, made, ada.account)
    assert "Séance en cours" not in text_of(ada.browser(site), f"/classes/{made.id}")
    with site.database.write() as db:
        plan = LessonPlan((EXERCISE,), Afterwards.challenge, OTHER)
        service.start_lesson(db, course, made, martin.account.id, plan, utc_now())
    shown = text_of(ada.browser(site), f"/classes/{made.id}").split('id="seance"')[1].split("</section>")[0]
    assert "à faire" in shown
    assert "défi" not in shown, "not before the exercises of the day"
    store(site.database, [Sent(ada.id, EXERCISE, utc_now(), 1.0)])
    shown = text_of(ada.browser(site), f"/classes/{made.id}").split('id="seance"')[1].split("</section>")[0]
    assert "Voici un défi" in shown
    assert "/l20/exercices/kabsch" in shown
