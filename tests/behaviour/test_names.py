"""What a teacher says of a group: who reads it, where, and what never changes by it."""

from __future__ import annotations

import io
import json
import re
import shutil
import tomllib
import zipfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from uuid import UUID

import pytest
from sqlalchemy import select

from graders.core.code.behaviour import BehaviourObserver
from graders.core.code.folder import check_known_functions, read_misconceptions
from graders.core.code.grading import CodeGrader
from graders.core.code.stored_answers import same_answers
from graders.core.contract.local import LOCAL
from server.audit.models import AuditAction, AuditEvent
from server.behaviour import service
from server.behaviour.export import anonymise_program, make_misconception_id
from server.classes.models import ClassRole, SchoolClass
from server.gradebook.models import Grading
from server.identity.models import Role
from tests.support.behaviour import DIFFERENCE, SUM, SUM_AGAIN, ask_all, failed_verdict, group_of, sent
from tests.support.classes import Person, new_class, person, seat
from tests.support.counting import Counted
from tests.support.quick import the_course
from tests.support.service import EXERCISE, Site

WORDS = {
    "title": "Les poses sont ajoutées",
    "explanation": "Vous ajoutez <b>a</b> et `b`.\n\nLe repère tourne.",
    "question": "Que vaut θ₁ ?",
}


@dataclass
class Scene:
    """A class with a teacher, an assistant and two students; programs of theirs that fail alike, and one that does
    not."""

    site: Site
    made: SchoolClass
    martin: Person
    assistant: Person
    ada: Person
    bob: Person
    by_ada: UUID
    by_bob: UUID
    other: UUID
    group: str

    @property
    def names(self) -> str:
        return f"/api/v1/classes/{self.made.id}/names/{EXERCISE}/{self.group}"

    @property
    def page(self) -> str:
        return f"/classes/{self.made.id}/groupes/{EXERCISE}/{self.group}"

    def name(self, who: Person | None = None, status: int = 200, **words: str) -> Any:
        answer = self.site.client.put(self.names, json={**WORDS, **words}, headers=(who or self.martin).headers)
        assert answer.status_code == status, answer.text
        return answer.json()

    def diagnosis(self, who: Person, submission: UUID) -> Any:
        return self.verdict(who, submission)["diagnosis"]

    def verdict(self, who: Person, submission: UUID) -> Any:
        answer = self.site.client.get(f"/api/v1/submissions/{submission}", headers=who.headers)
        assert answer.status_code == 200, answer.text
        return answer.json()["verdict"]


@pytest.fixture
def scene(site: Site) -> Scene:
    martin = person(site, Role.teacher, "Mme Martin")
    made = new_class(site.database, martin.account)
    people = [person(site, name=name) for name in ("Aide", "Ada Lovelace", "Bob")]
    for one, role in zip(people, (ClassRole.assistant, ClassRole.student, ClassRole.student), strict=True):
        seat(site.database, made, one.account, role)
    assistant, ada, bob = people
    attempts = ((ada, SUM_AGAIN), (bob, SUM), (bob, DIFFERENCE))
    ids = [sent(site.database, who.account, code) for who, code in attempts]
    ask_all(site.database, site.settings)
    return Scene(site, made, martin, assistant, ada, bob, *ids, group_of(site.database, ids[0]))


def test_a_name_is_the_diagnosis_of_the_whole_group_now_and_later(scene: Scene) -> None:
    assert scene.diagnosis(scene.ada, scene.by_ada) is None
    told = scene.name()
    assert told == {**WORDS, "exercise": EXERCISE, "group": scene.group, "students": 2}
    expected = {
        "id": scene.group,
        "title": WORDS["title"],
        "explanation": f"{WORDS['explanation']}\n\n{WORDS['question']}",
        "source": "teacher",
    }
    assert scene.diagnosis(scene.ada, scene.by_ada) == scene.diagnosis(scene.bob, scene.by_bob) == expected
    assert scene.diagnosis(scene.bob, scene.other) is None
    later = sent(scene.site.database, scene.bob.account, SUM + "\n# encore\n")
    ask_all(scene.site.database, scene.site.settings)
    assert scene.diagnosis(scene.bob, later) == expected
    events = scene.site.client.get(f"/api/v1/submissions/{later}/events", headers=scene.bob.headers).text
    assert json.loads(re.search(r"data: (.*)", events)[1])["verdict"]["diagnosis"] == expected  # type: ignore[index]
    for who, address in ((scene.ada, f"/soumissions/{scene.by_ada}"), (scene.bob, "/l20/exercices/poses")):
        shown = who.browser(scene.site).get(address).text
        assert "Vu par votre enseignant" in shown
        assert "Erreur reconnue" not in shown
        assert "&lt;b&gt;a&lt;/b&gt; et <code>b</code>" in shown


def test_stored_verdicts_and_known_misconceptions_never_change(scene: Scene) -> None:
    known = sent(scene.site.database, scene.ada.account, SUM, failed_verdict(named="known"))
    ask_all(scene.site.database, scene.site.settings)
    assert group_of(scene.site.database, known) == scene.group
    with scene.site.database.read() as db:
        before = [(one.id, one.verdict, one.diagnosis) for one in db.execute(select(Grading)).scalars()]
    scene.name()
    assert scene.diagnosis(scene.ada, known)["id"] == "known"
    assert "dans un de ces programmes" in scene.martin.browser(scene.site).get(scene.page).text
    with scene.site.database.read() as db:
        assert [(one.id, one.verdict, one.diagnosis) for one in db.execute(select(Grading)).scalars()] == before


def test_a_name_belongs_to_one_class(scene: Scene) -> None:
    durand = person(scene.site, Role.teacher, "M. Durand")
    elsewhere = new_class(scene.site.database, durand.account, "PSI")
    carl = person(scene.site, name="Carl")
    scene.name()
    seat(scene.site.database, elsewhere, carl.account)
    mine = sent(scene.site.database, carl.account, SUM)
    ask_all(scene.site.database, scene.site.settings)
    assert group_of(scene.site.database, mine) == scene.group, "groups are of the exercise"
    assert scene.diagnosis(carl, mine) is None
    scene.name(durand, status=404)
    there = scene.names.replace(str(scene.made.id), str(elsewhere.id))
    assert scene.site.client.put(there, json={**WORDS, "title": "Autre"}, headers=durand.headers).status_code == 200
    assert scene.diagnosis(carl, mine)["title"] == "Autre"
    assert scene.diagnosis(scene.ada, scene.by_ada)["title"] == WORDS["title"]


def test_changing_and_withdrawing_a_name_is_audited(scene: Scene) -> None:
    scene.name()
    scene.name()
    scene.name(title="Mieux dit")
    assert scene.diagnosis(scene.ada, scene.by_ada)["title"] == "Mieux dit"
    for _ in range(2):
        answer = scene.site.client.delete(scene.names, headers=scene.martin.headers)
        assert (answer.status_code, answer.content) == (204, b"")
    assert scene.diagnosis(scene.ada, scene.by_ada) is None
    with scene.site.database.read() as db:
        noted = db.execute(select(AuditEvent).order_by(AuditEvent.at)).scalars().all()
    assert [one.what for one in noted] == [AuditAction.name_given, AuditAction.name_given, AuditAction.name_withdrawn]
    assert noted[1].before == {"title": WORDS["title"]}
    assert noted[1].after == {"title": "Mieux dit"}
    assert all(one.by == scene.martin.id and EXERCISE in one.about for one in noted)


@pytest.mark.parametrize(
    ("words", "says"),
    [
        ({"title": " \n"}, "Le titre"),
        ({"explanation": "\u202e\u200b"}, "explication"),
        ({"title": "x" * 201}, "201"),
        ({"explanation": "x" * 4001}, "4001"),
        ({"question": "x" * 1001}, "1001"),
    ],
)
def test_descriptions_are_bounded(scene: Scene, words: dict[str, str], says: str) -> None:
    assert says in scene.name(status=422, **words)["detail"]
    assert scene.diagnosis(scene.ada, scene.by_ada) is None


def test_descriptions_hold_no_invisible_characters() -> None:
    given = service.parse_group_description("  Une\u202e \x00erreur\n\n", "a\r\n\r\n\tb \ud800\n", "")
    assert given == service.GroupDescription("Une erreur", "a\n\n\tb", "")


def test_unknown_groups_are_not_found(scene: Scene) -> None:
    for names in (
        scene.names + "0",
        scene.names.replace("poses", "kabsch"),
        scene.names.replace(str(scene.made.id), str(scene.by_ada)),
    ):
        assert scene.site.client.put(names, json=WORDS, headers=scene.martin.headers).status_code == 404


def test_the_board_shows_groups_of_equal_failures(scene: Scene) -> None:
    students, exercises = [scene.ada.id, scene.bob.id], [EXERCISE]
    database = scene.site.database

    def unnamed() -> list[service.UnnamedGroup]:
        with database.read() as db:
            return list(service.list_unnamed_groups(db, scene.made.id, students, exercises))

    first, second = unnamed()
    assert {first.students, second.students} == {(scene.ada.id,), (scene.bob.id,)}, "the latest attempt counts alone"
    again = sent(database, scene.bob.account, SUM)
    ask_all(database, scene.site.settings)
    (only,) = unnamed()
    assert (only.exercise, only.group, only.submission, only.title) == (EXERCISE, scene.group, again, None)
    assert set(only.students) == set(students)
    scene.name()
    assert unnamed()[0].title == WORDS["title"]
    sent(database, scene.bob.account, SUM, failed_verdict(named="known"))
    assert unnamed()[0].students == (scene.ada.id,)
    with database.read() as db:
        assert not service.list_unnamed_groups(db, scene.made.id, [], exercises)
        with Counted(database) as asked:
            service.list_unnamed_groups(db, scene.made.id, students, exercises)
    assert len(asked.statements) == 1


def test_the_page_of_a_group(scene: Scene) -> None:
    teacher, helper = scene.martin.browser(scene.site), scene.assistant.browser(scene.site)
    page = teacher.get(scene.page).text
    assert "2 élèves ont envoyé 2 programmes" in page
    assert "1 élève en est encore là" in page
    assert f'href="/soumissions/{scene.by_ada}">Ada Lovelace</a>' in page
    assert "Que vaut θ₁" in page, "the hints of the failed checks are suggested"
    shown = page[page.index('id="programme"') : page.index('id="nommer"')]
    assert "Ada" not in shown, "the shortest is read: Bob's"
    assert "<form" not in helper.get(scene.page).text.split('id="nommer"')[1]
    other = teacher.get(f"{scene.page}?essai={scene.by_ada}").text
    assert "Ada Lovelace" in other[other.index('id="programme"') : other.index('id="nommer"')]
    assert teacher.get(f"{scene.page}?essai={scene.other}").status_code == 404
    refused = teacher.post(scene.page, data={"title": "Seul", "explanation": ""})
    assert refused.status_code == 422
    assert 'value="Seul"' in refused.text
    assert teacher.post(scene.page, data=WORDS).status_code == 303
    page = teacher.get(scene.page).text
    assert f'value="{WORDS["title"]}"' in page
    assert "erreur.zip" in page
    assert WORDS["title"] in helper.get(scene.page).text
    other_group = scene.page.replace(scene.group, group_of(scene.site.database, scene.other))
    assert f"?depuis={scene.group}" in teacher.get(other_group).text
    assert f'value="{WORDS["title"]}"' in teacher.get(f"{other_group}?depuis={scene.group}").text
    assert teacher.post(scene.page, data={"title": "", "explanation": "", "question": ""}).status_code == 303
    assert scene.diagnosis(scene.ada, scene.by_ada) is None


def test_a_group_page_takes_as_many_queries_for_many_programs(scene: Scene) -> None:
    teacher = scene.martin.browser(scene.site)
    teacher.get(scene.page)
    with Counted(scene.site.database) as few:
        teacher.get(scene.page)
    for k in range(8):
        sent(scene.site.database, (scene.ada, scene.bob)[k % 2].account, SUM + f"\nx = {k}\n")
    ask_all(scene.site.database, scene.site.settings)
    with Counted(scene.site.database) as many:
        assert "10 programmes" in teacher.get(scene.page).text
    assert len(many.statements) == len(few.statements)


def test_a_named_group_is_exported_for_the_course(scene: Scene, tmp_path: Path) -> None:
    """The archive, put where it belongs, is read by the loader of misconceptions, and behaves as the group."""
    teacher = scene.martin.browser(scene.site)
    assert teacher.get(f"{scene.page}/erreur.zip").status_code == 404
    scene.name(explanation='Avec "guillemets", \\ et\nune ligne.')
    answer = teacher.get(f"{scene.page}/erreur.zip")
    assert answer.headers["content-type"] == "application/zip"
    exercise = the_course().exercises[EXERCISE]
    assert isinstance(exercise.grader, CodeGrader)
    folder = tmp_path / "poses"
    shutil.copytree(exercise.grader.folder, folder)
    with zipfile.ZipFile(io.BytesIO(answer.content)) as archived:
        assert archived.namelist() == ["misconceptions.toml", "misconceptions/les_poses_sont_ajoutees.py"]
        catalogue = folder / "misconceptions.toml"
        entry = archived.read("misconceptions.toml").decode()
        catalogue.write_text(catalogue.read_text(encoding="utf-8") + "\n" + entry, encoding="utf-8")
        (folder / archived.namelist()[1]).write_bytes(archived.read(archived.namelist()[1]))
    assert tomllib.loads(entry)["misconception"][0]["explanation"] == 'Avec "guillemets", \\ et\nune ligne.'
    read = list(read_misconceptions(folder, exercise.solution))
    check_known_functions(folder, read, [one.name for one in exercise.functions])
    mine = read[-1]
    assert (mine.id, mine.title, mine.question, mine.whole) == (
        "les_poses_sont_ajoutees", WORDS["title"], WORDS["question"], True,
    )  # fmt: skip
    assert mine.functions == ("composer", "inverse", "relatif")
    asked = BehaviourObserver(exercise.grader, exercise.version)
    unread = asked.observe(mine.source.encode(), LOCAL)
    assert same_answers(unread.answers, asked.observe(exercise.solution.encode(), LOCAL).answers), "not run unread"
    once_read = mine.source.replace("RELU = False", "RELU = True").encode()
    assert same_answers(asked.observe(once_read, LOCAL).answers, asked.observe(SUM.encode(), LOCAL).answers)


def test_exported_programs_are_anonymous() -> None:
    source = '''\ufefffrom __future__ import annotations
"""Par Ada Lovelace."""
# Ada
__author__ = "Ada Lovelace"
__credits__: str = f"{1}"

def composer(a, b):
    "Ada"
    if a is None:
        raise ValueError("demander à ada")  # Ada
    chemin = "C:/ada_lovelace/"

class Vide:
    """Ada."""

if __name__ == "__main__":
    print("Ada")
'''
    text = anonymise_program(source.encode(), ["Ada", "Lovelace", "de"])
    assert "ada" not in text.lower()
    assert "lovelace" not in text.lower()
    assert "__credits__" not in text
    assert "demander à élève" in text
    names: dict[str, Any] = {}
    exec(compile("x = 1\n\n\n" + text, "<export>", "exec"), names)
    assert names["composer"](1, 2) is None


def test_misconception_ids_are_file_names() -> None:
    assert make_misconception_id("La rotation est oubliée !", ()) == "la_rotation_est_oubliee"
    assert make_misconception_id("../../etc", ()) == "etc"
    assert make_misconception_id("角度", ()) == "erreur"
    assert make_misconception_id("2 fois", ()) == "erreur_2_fois"
    assert make_misconception_id("Degrés", {"degres", "degres_2"}) == "degres_3"
