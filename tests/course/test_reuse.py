"""What an exercise reuses of others: their functions, one's own before the course's."""

from pathlib import Path

from graders.core.code.checks import Trial
from graders.core.code.exercise import CodeDefinition
from graders.core.contract.outcomes import Outcome
from graders.core.contract.program import KitSettings
from graders.discovery import Discovery
from server.course import Course
from server.course.reuse import build_importable_library
from server.grading.sandbox_grader import SandboxGrader
from server.sandbox import Sandbox
from tests.support.small_course import EXERCISE, CourseFolder


def definition(folder: Path, function: str) -> CodeDefinition:
    check = Trial(
        id="t", title="T", points=20, functions=(function,), hint="?", protocol=lambda bench: judge(bench.call)
    )

    def judge(call: object) -> None:
        assert callable(call)
        if call(function, 3) != 6:
            raise AssertionError

    source = f"def {function}(x):\n    return 2 * x\n"
    return CodeDefinition(folder, (check,), lambda _: KitSettings("m9", {}), source)


def built(folder: CourseFolder, **reuses: str) -> Course:
    """Exercises a, b and c, whose functions are double_a and so on; each may reuse others."""
    found = {}
    for slug in "abc":
        folder.add(slug)
        card = EXERCISE.replace("double", f"double_{slug}").replace(
            "\n[[", f"reuses = [{reuses.get(slug, '')}]\n\n[[", 1
        )
        folder.write(f"curriculum/m9/exercices/{slug}/exercise.toml", card)
        found[f"m9/{slug}"] = definition(folder.root / "graders" / "m9" / slug, f"double_{slug}")
    return folder.load(Discovery(found, ()), render=False)


def test_what_is_reused_comes_with_what_it_reuses(course_folder: CourseFolder) -> None:
    course = built(course_folder, b='"a"', c='"b"')
    assert course.problems == ()
    assert [one.slug for one in course.importable_exercises("m9/c")] == ["b", "a"]
    files = build_importable_library(course, "m9/c", {"m9/a": b"x = 1\n"})
    assert [(file.label, file.functions, file.sealed, file.offered) for file in files] == [
        ("b", ("double_b",), True, True),
        ("a", ("double_a",), False, True),
        ("a", ("double_a",), True, False),
    ]
    assert [file.offered for file in build_importable_library(course, "m9/c", {}, {"m9/a"})] == [True, False]


def test_what_cannot_be_reused_is_said_at_its_line(course_folder: CourseFolder) -> None:
    course = built(course_folder, a='"b"', b='"a"', c='"absent"')
    assert [(problem.path.parent.name, problem.line) for problem in course.problems] == [("a", 4), ("b", 4), ("c", 4)]
    assert all(not exercise.reuses for exercise in course.exercises.values())


def test_a_version_changes_with_what_is_reused(course_folder: CourseFolder) -> None:
    alone = built(course_folder).exercises["m9/c"].version
    assert built(course_folder, c='"a"').exercises["m9/c"].version != alone


def test_ones_own_function_is_run_before_the_courses(course_folder: CourseFolder) -> None:
    course = built(course_folder, b='"a"')
    source = b"from mes_fonctions import double_a\ndef double_b(x):\n    return double_a(x)\n"
    own = {"m9/a": b"print('la mienne')\ndef double_a(x):\n    return x + x\n"}
    with Sandbox(course.kits) as sandbox:
        grader = SandboxGrader(course, sandbox)
        mine, theirs = (grader.grade("m9/b", source, 1, own=files).verdict for files in (own, {}))
    assert (mine.outcome, theirs.outcome) == (Outcome.OK, Outcome.OK)
    assert (mine.stdout, theirs.stdout) == ("la mienne\n", "")
