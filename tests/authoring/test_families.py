"""The families of misconceptions: what files them, and what is wrong in how they are filed."""

from __future__ import annotations

from dataclasses import replace

import pytest

from server.authoring.families import find_family_faults
from tests.support.quick import the_course
from tests.support.small_course import CourseFolder

FAMILIES = '[[family]]\nid = "{}"\ntitle = "Un signe"\nsummary = "Un signe est faux."\n{}'


@pytest.mark.parametrize(
    ("family", "filing", "expected"),
    [
        (FAMILIES.format("signe", 'slips = ["oppose"]'), "", []),
        (FAMILIES.format("signe", 'slips = ["opposé"]'), "", ["« opposé » n’est pas une étourderie connue"]),
        (FAMILIES.format("signe", ""), "", ["ne réunit rien"]),
        (
            FAMILIES.format("signe", 'slips = ["oppose"]'),
            '[families]\ncarre = ["perdue"]\n',
            ["« carre » n’est pas une famille", "« perdue » n’est pas une erreur de « a »"],
        ),
    ],
    ids=["sound", "unknown slip", "empty family", "unknown names"],
)
def test_unknown_names_are_faults(course_folder: CourseFolder, family: str, filing: str, expected: list[str]) -> None:
    course_folder.write("curriculum/families.toml", family)
    course_folder.write("curriculum/m9/exercices/a/families.toml", filing)
    course = course_folder.load(render=False)
    assert course.problems == ()
    messages = [problem.message for problem in find_family_faults(course)]
    assert len(messages) == len(expected)
    assert all(part in message for part, message in zip(expected, messages, strict=True))


def test_malformed_files_are_told_with_their_place(course_folder: CourseFolder) -> None:
    family = FAMILIES.format("signe", "")
    course_folder.write("curriculum/families.toml", family + family)
    filing = '[apart]\n"une raison" = ["x"]\n"une autre" = ["x"]\n'
    course_folder.write("curriculum/m9/exercices/a/families.toml", filing)
    course = course_folder.load(render=False)
    found = {(problem.path.parent.name, problem.line): problem.message for problem in course.problems}
    assert "une autre famille se nomme déjà" in found["curriculum", 6]
    assert "« x » est rangée deux fois" in found["a", None]


def test_every_misconception_of_the_course_is_filed() -> None:
    course = the_course()
    assert [*find_family_faults(course)] == []
    exercises = course.exercises.values()
    shared = {name: {it.id for it in exercises if name in it.filing.families.values()} for name in course.families}
    assert len(shared["angle_non_ramene"]) >= 5, "the angle that one forgets to wrap is one family across exercises"
    assert len({exercise.partition("/")[0] for exercise in shared["sigma_et_variance"]}) > 1, "across modules too"


def test_a_misconception_that_is_filed_nowhere_is_a_fault() -> None:
    course = the_course()
    module = course.modules["l20"]
    (poses,) = (exercise for exercise in module.exercises if exercise.slug == "poses")
    families = {mistake: name for mistake, name in poses.filing.families.items() if mistake != "angle_jamais_ramene"}
    unfiled = replace(poses, filing=replace(poses.filing, families=families))
    exercises = tuple(unfiled if exercise is poses else exercise for exercise in module.exercises)
    modules = {**course.modules, "l20": replace(module, exercises=exercises)}
    (problem,) = find_family_faults(replace(course, modules=modules))
    assert problem.path.parent.name == "poses"
    assert "« angle_jamais_ramene » n’a pas de famille" in problem.message


def test_a_mistake_of_one_exercise_alone_has_a_name_of_its_own(course_folder: CourseFolder) -> None:
    course_folder.write("curriculum/families.toml", FAMILIES.format("signe", 'slips = ["oppose"]'))
    for slug, reason in (("a", "propre à cet exercice"), ("b", "même nom, autre erreur")):
        course_folder.write(f"curriculum/m9/exercices/{slug}/families.toml", f'[apart]\n"{reason}" = ["perdue"]\n')
    found = [(fault.path.parent.name, fault.message) for fault in find_family_faults(course_folder.load(render=False))]
    assert [folder for folder, message in found if "« b » a une erreur du même nom" in message] == ["a"]
