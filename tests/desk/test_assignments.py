"""Pages of assignments: given, changed, exempted from by a teacher; found by students with their own dates."""

from __future__ import annotations

import csv
import io
import re
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from html import unescape
from typing import Any
from urllib.parse import quote
from uuid import UUID, uuid4

import pytest
from hypothesis import given
from hypothesis import strategies as st
from sqlalchemy import update

from server.assignments.counting import AttemptMark
from server.assignments.editing import purge_removed_assignments
from server.assignments.models import Assignment, Exemption, LatePolicy, WeightedExercise
from server.assignments.rules import MAX_POINTS, Rules, rules_in_force
from server.assignments.schemas import AssignmentInput
from server.audit.models import AuditAction, AuditEvent
from server.base.school_time import format_field
from server.classes.models import Membership, SchoolClass
from server.database import utc_now
from server.desk.assignments import late_line
from server.desk.own.views import exercise_standing
from server.gradebook.models import Standing
from server.identity.models import Account, Role
from server.marks.models import Override
from server.marks.schemas import ExerciseMark
from server.submissions.models import Submission
from server.web.words import format_long_time
from tests.support.classes import Person, new_class, person, seat
from tests.support.client import TestClient
from tests.support.counting import Counted
from tests.support.forms import hidden_fields
from tests.support.service import EXERCISE, Site, worker_of

DAY = timedelta(days=1)
NOW = utc_now().replace(second=0, microsecond=0)
OTHER = "l20/calcul_odometrie"
GOOD: dict[str, Any] = {
    "titre": "Se <repérer>",
    "exercice": [EXERCISE, OTHER],
    f"poids:{EXERCISE}": "2,5",
    "ouvre": format_field(NOW - DAY),
    "rendre": format_field(NOW + 2 * DAY),
    "ferme": format_field(NOW + 6 * DAY),
    "retard": "penalty",
    "par_jour": "2",
}


@dataclass
class School:
    site: Site
    made: SchoolClass
    martin: TestClient
    ada: Person
    bob: Person

    @property
    def href(self) -> str:
        return f"/classes/{self.made.id}"

    def give(self, **changes: Any) -> str:
        answer = self.martin.post(f"{self.href}/devoirs", data=GOOD | changes)
        assert answer.status_code == 303, told(answer.text)
        return str(answer.headers["location"])

    def stored(self, table: Any) -> list[Any]:
        with self.site.database.read() as db:
            return list(db.query(table).all())


def written(when: datetime) -> str:
    """Return a moment as `read` shows it."""
    return format_long_time(when).replace("\u00a0", " ")


def told(text: str) -> str:
    """What a page says, without its tags."""
    return re.sub(r"\s+", " ", unescape(re.sub(r"<[^>]+>", " ", text.rsplit("<main", maxsplit=1)[-1])))


def read(browser: TestClient, path: str, status: int = 200) -> str:
    answer = browser.get(path)
    assert answer.status_code == status, answer.text
    return told(answer.text)


@pytest.fixture
def school(site: Site) -> School:
    martin, ada, bob = person(site, Role.teacher, "Mme Martin"), person(site, name="Ada"), person(site, name="Bob")
    made = new_class(site.database, martin.account)
    seat(site.database, made, ada.account, groups=["TP1"])
    seat(site.database, made, bob.account)
    return School(site, made, martin.browser(site), ada, bob)


def test_what_was_solved_before_a_test_is_not_said_to_be_done_in_it(school: School) -> None:
    now = utc_now()
    with school.site.database.write() as db:
        for exercise in (EXERCISE, OTHER):
            row = {"best_score": 1.0, "attempts": 1, "last_outcome": "ok", "last_at": now, "first_success_at": now}
            db.add(Standing(account_id=school.ada.id, exercise=exercise, **row))
    assert "1 sur 2 élèves ont tout réussi" in read(school.martin, school.give())
    test = school.give(mode="test", duree="60")
    for path in (test, f"{school.href}/devoirs"):
        assert "0 sur 2 élèves ont commencé" in read(school.martin, path)


def test_an_assignment_is_given_shown_changed_and_taken_back(school: School) -> None:
    assert "Aucun devoir" in read(school.martin, f"{school.href}/devoirs")
    href = school.give()
    page = school.martin.get(href).text
    assert "Se &lt;repérer&gt;" in page
    shown = told(page)
    assert f"Date limite {written(NOW + 2 * DAY)}" in shown
    assert "coefficient 2,5" in shown
    assert "chaque jour de retard commencé coûte 2 points sur 20 : 18 au plus le premier jour" in shown
    assert '<svg class="late-line"' in page
    assert "▶ ouvert · 2 exercices · 0 sur 2 élèves ont tout réussi" in read(school.martin, f"{school.href}/devoirs")

    form = school.martin.get(f"{href}/modifier").text
    assert f'value="{GOOD["rendre"]}"' in form
    changed = GOOD | {"titre": "Deux", "ferme": "", "retard": "accept", "exercice": [OTHER]}
    assert school.martin.post(f"{href}/modifier", data=changed).headers["location"] == href
    assert "reste ouvert" in read(school.martin, href)
    assert "Supprimé, ce devoir quitte le carnet et la page de 2 élèves." in read(school.martin, href)
    assert school.martin.post(f"{href}/supprimer").headers["location"] == f"{school.href}/devoirs"
    assert school.martin.get(href).status_code == 404


def test_a_deletion_is_undone_for_thirty_days(school: School) -> None:
    href = school.give()
    own = read(school.ada.browser(school.site), school.href)
    assert "Se <repérer>" in own
    school.martin.post(f"{href}/supprimer")
    assert school.martin.get(f"{href}/modifier").status_code == 404
    listed = school.martin.get(f"{school.href}/devoirs").text
    assert "Supprimés depuis peu" in listed
    assert "Se <repérer>" not in read(school.ada.browser(school.site), school.href)
    assert "Aucun devoir n’est encore donné" in listed
    assert school.martin.post(f"{href}/retablir").headers["location"] == href
    assert school.martin.post(f"{href}/retablir").status_code == 303, "it is restored already"
    assert school.martin.post(f"{school.href}/devoirs/{uuid4()}/retablir").status_code == 404
    assert "Supprimés depuis peu" not in school.martin.get(f"{school.href}/devoirs").text
    assert read(school.ada.browser(school.site), school.href) == own

    school.martin.post(f"{href}/supprimer")
    for days, left in ((29, 1), (31, 0)):
        with school.site.database.write() as db:
            db.execute(update(Assignment).values(removed_at=utc_now() - timedelta(days=days)))
            purge_removed_assignments(db, utc_now())
        assert len(school.stored(Assignment)) == left


def test_a_paper_of_the_course_is_given_as_a_test_of_its_time(school: School) -> None:
    listed = school.martin.get(f"{school.href}/devoirs").text
    (href,) = re.findall(rf'href="({school.href}/devoirs/nouveau\?sujet=\w+)"', listed)
    form = unescape(school.martin.get(href).text)
    ticked = re.findall(r'name="exercice" value="([^"]+)" checked', form)
    paper = ("epreuve_calculs", "epreuve_preuve", "epreuve_lecture", "occupation")
    assert set(ticked) == {f"l20/{slug}" for slug in paper}
    chosen = {name: re.findall(rf'name="{name}"[^>]* value="([^"]+)"', form)[0] for name in ("titre", "duree")}
    assert chosen["duree"] == "120"
    assert re.search(r'value="test"[^>]*(checked|selected)', form)
    school.give(**chosen, exercice=ticked, mode="test", retard="accept", par_jour="")
    (made,) = school.stored(Assignment)
    assert (made.title, made.mode, made.duration_minutes) == (chosen["titre"], "test", 120)
    unknown = school.martin.get(f"{school.href}/devoirs/nouveau?sujet=slam").text
    assert not re.search(r'name="exercice" value="[^"]+" checked', unknown)


def test_a_field_left_as_it_was_keeps_the_very_second(school: School) -> None:
    href = school.give()
    exact = datetime(2031, 10, 26, 1, 30, 17, tzinfo=UTC)  # the second 2:30 of that night in Paris
    with school.site.database.write() as db:
        db.query(Assignment).one().closes_at = exact
    assert school.martin.post(f"{href}/modifier", data=GOOD | {"ferme": format_field(exact)}).status_code == 303
    assert school.stored(Assignment)[0].closes_at == exact


WRONG: list[tuple[dict[str, Any], str]] = [
    ({"titre": " "}, "Donnez au devoir un titre"),
    ({"exercice": []}, "Choisissez au moins un exercice."),
    ({"exercice": ["l20/rien"]}, "n’est pas du module"),
    ({f"poids:{EXERCISE}": "beaucoup"}, "« beaucoup » n’est pas un nombre"),
    ({f"poids:{EXERCISE}": "0"}, "plus grand que 0"),
    ({"par_jour": ""}, "combien de points"),
    ({"par_jour": "inf"}, "« inf » n’est pas un nombre"),
    ({"par_jour": "1e9"}, "n’est pas un nombre"),
    ({"rendre": ""}, "demande une date de remise"),
    ({"rendre": format_field(NOW - 2 * DAY)}, "La date de remise vient avant l’ouverture."),
    ({"ferme": "2031-03-30T02:30"}, "il n’est jamais 2 h 30 ce jour-là"),
    ({"ferme": "<script>"}, "« <script> » n’est pas une date"),
    ({"retard": "peut-être"}, "Ce choix n’est pas proposé."),
    ({"mode": "test", "duree": "12,5"}, "nombre entier de minutes"),
    ({"duree": "60"}, "Seul un contrôle a une durée"),
]


def test_what_is_refused_is_told_at_its_field_and_nothing_typed_is_lost(school: School) -> None:
    for change, why in WRONG:
        answer = school.martin.post(f"{school.href}/devoirs", data=GOOD | change)
        assert (answer.status_code, why in told(answer.text)) == (422, True), change
        assert "<script>" not in answer.text.split("<main")[1]
        assert f'value="{(GOOD | change)["ouvre"]}"' in answer.text
    assert school.stored(Assignment) == []
    drawn = school.martin.post(f"{school.href}/devoirs", data=GOOD | {"apercu": "oui"})
    assert (drawn.status_code, '<svg class="late-line"' in drawn.text) == (200, True)
    assert school.stored(Assignment) == []
    files = {"titre": ("a.txt", b"x"), "exercice": ("b.txt", b"y")}
    assert school.martin.post(f"{school.href}/devoirs", files=files).status_code == 422


def test_several_students_are_exempted_at_once_and_it_is_listed_exported_revoked(school: School) -> None:
    page = school.give() + "/amenagements"
    both = [str(school.ada.id), str(school.bob.id)]
    later = NOW + 9 * DAY
    granted = {"eleve": both, "rendre": format_field(later), "raison": "=SOMME(1)"}
    assert school.martin.post(page, data=granted).headers["location"] == page
    assert school.martin.post(page, data={"groupe": "TP1", "dispense": "oui", "raison": "voyage"}).status_code == 303
    shown = read(school.martin, page)
    assert shown.index("groupe TP1") < shown.index("Ada Date limite") < shown.index("Bob Date limite")
    assert written(later) in shown
    newest = read(school.martin, f"{page}?tri=date")
    assert newest.index("groupe TP1") < newest.index("Bob")

    exported = school.martin.get(f"{page}.csv")
    assert exported.content.startswith(b"\xef\xbb\xbf")
    assert exported.content.count(b"\r\n") == 4
    rows = list(csv.DictReader(io.StringIO(exported.content.decode("utf-8-sig")), delimiter=";"))
    assert [(row["Pour"], row["Groupe"], row["Raison"]) for row in rows] == [
        ("", "TP1", "voyage"), ("Ada", "", "'=SOMME(1)"), ("Bob", "", "'=SOMME(1)"),
    ]  # fmt: skip

    sooner = {"eleve": both[0], "rendre": format_field(NOW + 3 * DAY), "remplacer": "oui"}
    school.martin.post(page, data=sooner)
    held = [one for one in school.stored(Exemption) if one.account_id == school.ada.id and one.revoked_at is None]
    assert [one.due_at for one in held] == [NOW + 3 * DAY]
    assert school.martin.post(f"{page}/{held[0].id}/retirer").status_code == 303
    assert school.martin.post(f"{page}/{uuid4()}/retirer").status_code == 404
    kinds = [one.what for one in school.stored(AuditEvent) if "exemption" in one.what]
    assert (kinds.count(AuditAction.exemption_made), kinds.count(AuditAction.exemption_revoked)) == (4, 2)
    for refused in (
        {}, {"eleve": both}, {"eleve": "zut", "rendre": format_field(later)}, {"groupe": "TP9", "dispense": "oui"},
        {"eleve": both, "groupe": "TP1", "dispense": "oui"}, {"eleve": both, "temps": "5"},
        {"eleve": both, "dispense": "peut-être"}, {"eleve": str(uuid4()), "dispense": "oui"},
    ):  # fmt: skip
        answer = school.martin.post(page, data=refused)
        assert (answer.status_code, "Rien n’est encore accordé" in told(answer.text)) == (422, True), refused


def test_a_student_finds_what_to_do_by_when_and_why(school: School) -> None:
    href = school.give()
    soon = {
        "titre": "Contrôle",
        "mode": "test",
        "ouvre": format_field(NOW + DAY),
        "rendre": "",
        "ferme": format_field(NOW + 3 * DAY),
    }
    school.give(**soon, retard="accept", duree="60")
    later = NOW + 9 * DAY
    grant = {"groupe": "TP1", "rendre": format_field(later), "raison": "secret médical"}
    school.martin.post(f"{href}/amenagements", data=grant)
    ada, bob = school.ada.browser(school.site), school.bob.browser(school.site)
    school.site.submit(school.ada.headers, code="x  # outcome: wrong_answer")
    assert worker_of(school.site.database, school.site.settings).run_one()

    page = read(ada, school.href)
    assert f"Date limite {written(later)}" in page
    assert "Un aménagement vous a été accordé." in page
    assert "½ Composer, inverser et comparer des poses 10 / 20" in page
    assert "○ Un pas d’odométrie, à la main à faire" in page
    assert "Les exercices seront montrés à l’ouverture." in page
    assert f"Date limite {written(NOW + 2 * DAY)}" in read(bob, school.href)
    assert "secret" not in page
    row = {"account_id": school.ada.id, "based_on": []}
    with school.site.database.write() as db:
        db.add(Override(class_id=school.made.id, exercise=EXERCISE, points=15.0, reason="bien à l’oral", **row))
    page = read(ada, school.href)
    assert "½ Composer, inverser et comparer des poses 15 / 20, note de votre enseignant : bien à l’oral" in page

    why = read(ada, f"{href}/pourquoi")
    assert f"groupe « TP1 » : {written(later)} — date appliquée" in why
    assert "secret" not in why
    assert "secret médical" in read(school.martin, f"{href}/pourquoi?eleve={school.ada.id}")
    read(ada, f"{href}/pourquoi?eleve={school.bob.id}", 403)
    read(school.martin, f"{href}/pourquoi?eleve={uuid4()}", 404)

    seen = school.martin.get(f"{school.href}/eleves/{school.ada.id}/comme")
    assert "Vous voyez cette page comme Ada la voit" in told(seen.text)
    assert "<form" not in seen.text.split("<main")[1]
    own_doors = ("Ma copie · ", "Ajouter ces dates à mon agenda ")  # lead to Ada's own pages
    same = page.split("À faire maintenant")[1].split("Votre place")[0]
    for door in own_doors:
        assert door in same
        same = same.replace(door, "")
    assert same == told(seen.text).split("À faire maintenant")[1].split("Votre place")[0]

    assert ada.get(href).headers["location"] == f"{school.href}#devoir-{href.rpartition('/')[2]}"
    assert ada.get(f"{school.href}/devoirs").headers["location"] == school.href


def test_what_is_due_soon_is_told_where_one_works(school: School) -> None:
    school.give()
    bob, stranger = school.bob.browser(school.site), person(school.site).browser(school.site)
    line = f"à rendre avant le {written(NOW + 2 * DAY)} (encore 2 exercices)"
    for path in ("/", "/l20"):
        assert line in read(bob, path)
        for nobody in (stranger, school.site.client, school.martin):
            assert "à rendre avant" not in read(nobody, path)
    of_exercise = read(bob, "/l20/exercices/poses")
    assert f"Date limite : {written(NOW + 2 * DAY)} (devoir « Se <repérer> »)" in of_exercise
    with school.site.database.write() as db:
        db.get_one(SchoolClass, school.made.id).archived_at = utc_now()
    assert "avant le" not in read(bob, "/l20/exercices/poses")
    assert line not in read(bob, "/")


def test_who_has_worked_ahead_has_done_it(school: School) -> None:
    ada = school.ada.browser(school.site)
    ada.post("/l20/exercices/poses/soumissions", data={"code": "x = 1"})
    while worker_of(school.site.database, school.site.settings).run_one():
        pass
    with school.site.database.write() as db:
        db.query(Submission).one().created_at = NOW - 2 * DAY
    school.give()
    assert "✓ Composer, inverser et comparer des poses réussi" in read(ada, school.href)
    dates = {"ouvre": format_field(NOW + DAY), "rendre": "", "ferme": format_field(NOW + 3 * DAY), "retard": "accept"}
    href = school.give(titre="Bientôt", exercice=EXERCISE, **dates)
    assert "◷ à venir · déjà fait" in read(ada, school.href)
    gradebook = school.martin.get(f"{school.href}/carnet").text
    assert f'href="{href}">le devoir' in gradebook
    assert "20 en cours" in told(gradebook)
    detail = school.martin.get(f"{school.href}/carnet?devoir={href.rpartition('/')[2]}").text
    for page in (detail, school.martin.get(school.href).text):
        assert f'href="{school.href}/recalculs?exercice={quote(EXERCISE, safe="")}">recorriger' in page
    row = {"account_id": school.ada.id, "exercise": "l20/calcul_odometrie", "based_on": []}
    with school.site.database.write() as db:
        db.add(Override(class_id=school.made.id, points=20.0, reason="à l’oral", **row))
    page = read(ada, school.href)
    assert "✓ tout est fait · 2 sur 2" in page.split("Faits, encore ouverts")[1]
    assert "À faire maintenant" not in page


def test_pages_ask_no_more_for_more_assignments_and_students(school: School) -> None:
    href = school.give()
    bob = school.bob.browser(school.site)
    pages = [(school.martin, f"{school.href}/devoirs"), (school.martin, f"{href}/amenagements"), (bob, school.href)]
    pages += [(bob, "/"), (bob, "/l20/exercices/poses"), (school.martin, f"{href}/pourquoi?eleve={school.bob.id}")]

    def asked() -> list[int]:
        counts = []
        for browser, path in pages:
            with Counted(school.site.database) as counted:
                read(browser, path)
            counts.append(len(counted.statements))
        return counts

    school.martin.post(f"{href}/amenagements", data={"groupe": "TP1", "dispense": "oui"})
    asked()
    few = asked()
    with school.site.database.write() as db:
        for number in range(12):
            account = Account(role=Role.student, name=f"Élève {number}")
            db.add(account)
            db.flush()
            db.add(Membership(class_id=school.made.id, account_id=account.id, groups=["TP2"]))
            db.add(Exemption(assignment_id=UUID(href.rpartition("/")[2]), account_id=account.id, excused=True))
    for number in range(5):
        school.give(titre=f"Devoir {number}")
    assert asked() == few
    assert max(few) <= 18


def test_a_copy_takes_the_assignments_along_at_their_time_of_day(school: School) -> None:
    summer = {"ouvre": "2031-03-24T08:00", "rendre": "2031-03-31T18:00", "ferme": "", "retard": "accept"}
    href = school.give(**summer)
    school.martin.post(f"{href}/amenagements", data={"groupe": "TP1", "dispense": "oui"})
    for fields, opens, due in (
        ({"semaines": "52"}, "2032-03-22T08:00", "2032-03-29T18:00"),
        ({"semaines": "-3"}, "2031-03-03T08:00", "2031-03-10T18:00"),
        ({"rentree": "2031-09-01", "semaines": "7"}, "2031-09-01T08:00", "2031-09-08T18:00"),
        ({"rentree": "2031-09-02"}, "2031-09-08T08:00", "2031-09-15T18:00"),
        ({"rentree": "2031-03-19"}, "2031-03-24T08:00", "2031-03-31T18:00"),
        ({"rentree": "2030-10-01"}, "2030-10-07T08:00", "2030-10-14T18:00"),
        ({}, "2032-03-22T08:00", "2032-03-29T18:00"),
    ):
        copied = school.martin.post(f"{school.href}/copier", data={"name": "PSI", **fields})
        assert copied.status_code == 303
        there = copied.headers["location"].rpartition("/")[2]
        (one,) = [one for one in school.stored(Assignment) if str(one.class_id) == there]
        assert (format_field(one.opens_at), format_field(one.due_at), one.closes_at) == (opens, due, None)
    assert len(school.stored(Exemption)) == 1
    before = len(school.stored(SchoolClass))
    for fields in ({"semaines": "9999"}, {"semaines": "un an"}, {"rentree": "demain"}, {"rentree": "2131-09-01"}):
        assert school.martin.post(f"{school.href}/copier", data={"name": "PSI", **fields}).status_code == 422
    assert len(school.stored(SchoolClass)) == before


def test_who_comes_goes_and_teaches_is_in_the_log(school: School) -> None:
    with school.site.database.write() as db:
        db.add(Account(role=Role.student, name="Carl", login="carl"))
    school.martin.post(f"{school.href}/eleves", data={"action": "retirer", "eleve": str(school.bob.id)})
    school.martin.post(f"{school.href}/eleves", data={"action": "retirer", "eleve": str(school.bob.id)})
    school.martin.post(f"{school.href}/eleves", data={"action": "reprendre", "eleve": str(school.bob.id)})
    for role in ("assistant", "enseignant"):
        named = school.martin.post(f"{school.href}/equipe", data={"login": "carl", "role": role})
        school.martin.post(f"{school.href}/equipe", data=hidden_fields(named.text, f"{school.href}/equipe"))
    found = school.stored(AuditEvent)
    assert [(one.what, one.before, one.after) for one in sorted(found, key=lambda one: one.at)] == [
        (AuditAction.student_removed, {"status": "active"}, {"status": "left"}),
        (AuditAction.student_admitted, {"status": "left"}, {"status": "active"}),
        (AuditAction.staff_changed, {"role": None}, {"role": "assistant"}),
        (AuditAction.staff_changed, {"role": "assistant"}, {"role": "teacher"}),
    ]
    assert {one.student for one in found[:2]} == {school.bob.id}
    listed = "nom,prenom\nLovelace,Grace\n"
    answer = school.site.client.post(
        f"/api/v1/classes/{school.made.id}/roster",
        content=listed,
        headers={"Content-Type": "text/csv", **school.ada.headers},
    )
    assert answer.status_code == 403
    assert len(school.stored(AuditEvent)) == len(found)
    shown = school.martin.post(f"{school.href}/liste", data={"texte": listed, "mode": "remplacer"}).text
    digest = re.search(r'name="attendu" value="(\w+)"', shown)
    assert digest
    school.martin.post(f"{school.href}/liste", data={"texte": listed, "mode": "remplacer", "attendu": digest[1]})
    new = [one.what for one in school.stored(AuditEvent)][len(found) :]
    assert sorted(new) == sorted(
        [AuditAction.student_admitted, AuditAction.student_removed, AuditAction.student_removed]
    )


rules = st.builds(
    lambda opens, due, more, late, per_day: rules_in_force(
        AssignmentInput(
            "x",
            (WeightedExercise("a"),),
            opens,
            opens + timedelta(hours=due) if due is not None or late is LatePolicy.penalty else None,
            None if more is None else opens + timedelta(hours=(due or 0) + more),
            late,
            per_day,
        ),
        (),
        UUID(int=0),
        (),
    ),
    st.datetimes(datetime(2020, 1, 1), datetime(2030, 1, 1), timezones=st.just(UTC)),
    st.integers(0, 900),
    st.none() | st.integers(0, 900),
    st.sampled_from(list(LatePolicy)),
    st.sampled_from([0.01, 0.3, 1.0, 2.5, 7.0, 20.0]),
)


@given(rules, st.floats(0.01, 0.99))
def test_the_line_goes_through_what_the_rules_give(found: Rules, share: float) -> None:
    line = late_line.draw_late_line(found)
    assert "nan" not in line.svg
    assert len(line.svg) < 12_000
    pieces = list(late_line._line_segments(found))
    for piece, following in zip(pieces, [*pieces[1:], None], strict=True):
        assert piece.start <= piece.end
        assert following is None or following.start == piece.end, "the line has no gap"
        if piece.start == piece.end:
            continue
        worth = (
            found.judge_timing(piece.start + share * (piece.end - piece.start)).apply_late_penalty(MAX_POINTS).points
        )
        if piece.left is None or piece.right is None:
            assert worth is None
            continue
        assert worth is not None
        drawn = piece.left + share * (piece.right - piece.left)
        # Beside the steps of the days, the last day takes only what is left, and the slope is that of whole days.
        assert worth == pytest.approx(drawn, abs=0 if piece.left == piece.right else 2 * found.late_per_day)


def test_what_a_student_is_told_of_an_exercise() -> None:
    def marked(counted: AttemptMark | None, attempts: int) -> ExerciseMark:
        return ExerciseMark(EXERCISE, 1.0, counted, None, None, attempts, None)

    full, late = marked(AttemptMark(uuid4(), 20.0, 20.0, 0), 3), marked(AttemptMark(uuid4(), 14.0, 20.0, 3), 1)
    assert exercise_standing(full, over=False) == ("done", "✓", "réussi")
    assert exercise_standing(late, over=True) == ("done", "✓", "réussi : 14 / 20")
    assert exercise_standing(marked(None, 2), over=False)[2] == "rien avant la date de remise"
    assert [exercise_standing(marked(None, 0), over=over)[2] for over in (False, True)] == ["à faire", "non rendu"]
