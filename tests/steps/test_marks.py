"""The line of a mistake is one at which undoing it makes the check pass, in the words of the program; else none."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import pytest

from graders.core.code.exercise import CodeDefinition
from graders.core.code.mutations import Edit, Model
from graders.core.code.repairs import find_repairs
from graders.core.contract.local import LOCAL
from graders.core.contract.program import KitSettings, PlannedCalls, Program
from graders.discovery import load_definition
from graders.typography import french
from server.steps import marks

POSES = load_definition("l20/poses")
ODOMETRY = load_definition("l20/odometrie")


@pytest.fixture(autouse=True)
def _as_long_as_it_takes(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(marks, "MAX_SECONDS", 60.0)


OTHERWISE = """import math

def norme(t):
    return math.atan2(math.sin(t), math.cos(t))

def composer(p, q):
    "La composition, écrite autrement que dans le modèle."
    cap = p[2]
    gauche = math.sin(cap)
    devant = math.cos(cap)
    X = p[0] + q[0] * devant {0} q[1] * gauche
    Y = p[1] + q[0] * gauche {1} q[1] * devant
    return np.array([X, Y, {2}])
"""


def mark(definition: object, mistake: str, source: str, check: str) -> int | None:
    assert isinstance(definition, CodeDefinition)
    found = marks.locate_mistake(definition, [mistake], source.encode(), check, LOCAL, seed=3)
    assert found is None or found.words == french(next(m.title for m in definition.misconceptions if m.id == mistake))
    return None if found is None else found.line


@pytest.mark.parametrize(
    ("changed", "mistake", "check", "line"),
    [
        (("-", "+", "p[2] + q[2]"), "angle_jamais_ramene", "composer_tours", 13),
        (("-", "+", "norme(p[2])"), "angle_de_b_oublie", "composer_exemples", 13),
        (("-", "+", "norme(cap + q[2])"), "angle_jamais_ramene", "composer_tours", None),  # it is right
        (("+", "-", "norme(cap + q[2])"), "rotation_a_l_envers", "composer_exemples", 11),
    ],
)
def test_the_line_is_found_in_a_program_written_otherwise(
    changed: tuple[str, ...], mistake: str, check: str, line: int | None
) -> None:
    assert mark(POSES, mistake, OTHERWISE.format(*changed), check) in {line, None}


def test_the_lines_of_the_catalogue_s_own_mistakes_are_never_wrong() -> None:
    assert isinstance(POSES, CodeDefinition)
    assert POSES.prober is not None
    model = POSES.prober.model
    found = {}
    checks = {
        "composer_exemples": ("ordre_echange", "degres_dans_cos", "composer_angle"),
        "inverse": ("inverse_angle",),
    }
    for check, mistakes in checks.items():
        for mistake in mistakes:
            edit = next(edit for edit in model.edits if edit.id == mistake)
            source = edit.apply(model.text)
            assert source is not None
            changed = [k for k, text in enumerate(source.splitlines(), 1) if text not in model.text.splitlines()]
            found[mistake] = mark(POSES, mistake, source, check)
            assert found[mistake] is None or found[mistake] in changed, (mistake, found)
    assert sum(line is not None for line in found.values()) >= 3


@pytest.mark.parametrize(
    "source", ["", "def composer(:", "\0", "def composer(a, b):\n    return a\n", "x = " + "(" * 500]
)
def test_nothing_is_marked_where_there_is_nothing_to_mark(source: str) -> None:
    assert mark(POSES, "rotation_a_l_envers", source, "composer_exemples") is None
    assert mark(POSES, "argument_modifie", source, "composer_exemples") is None


def test_a_program_made_to_be_slow_to_read_is_left_alone() -> None:
    assert isinstance(ODOMETRY, CodeDefinition)
    assert ODOMETRY.prober is not None
    many = " + ".join(f"a{k} * b{k} - c{k}" for k in range(9))
    source = "def odometrie(pose, ds_g, ds_d, L):\n" + "".join(f"    x{k} = {many}\n" for k in range(3))
    looks = itertools.count()
    found = find_repairs(ODOMETRY.prober.model, "depart_oublie", ["odometrie"], source, lambda: next(looks) > 100)
    assert sum(1 for _ in found) <= 100
    assert next(looks) <= 110
    assert not list(find_repairs(ODOMETRY.prober.model, "depart_oublie", ["odometrie"], source * 40, lambda: False))


def test_once_patience_is_spent_no_program_starts(monkeypatch: pytest.MonkeyPatch) -> None:
    """A program that sleeps at its first line would keep a check that starts it dozens of times."""
    started = list[bytes]()

    class Slow:
        def open(self, source: bytes, kit: KitSettings, ahead: Sequence[PlannedCalls] = ()) -> Program:
            started.append(source)
            monkeypatch.setattr("server.steps.marks.time.monotonic", lambda: float("inf"))
            return LOCAL.open(source, kit, ahead)

    assert isinstance(POSES, CodeDefinition)
    source = OTHERWISE.format("-", "+", "p[2] + q[2]").encode()
    assert marks.locate_mistake(POSES, ["angle_jamais_ramene"], source, "composer_tours", Slow(), seed=3) is None
    assert len(started) == 1


def test_a_mistake_in_the_slices_of_an_index_is_undone() -> None:
    edit = Edit("coin", (("H[3:, 3:]", "H[:3, :3]"),), frozenset(("bloc",)))
    model = Model("def bloc(H):\n    return H[3:, 3:]\n", [edit])
    found = find_repairs(model, "coin", ["bloc"], "def bloc(A):\n    B = 2 * A[:3, :3]\n    return B\n", lambda: False)
    assert "2 * (A[3:, 3:])" in [repair.text.splitlines()[1].partition("= ")[2] for repair in found]


def test_a_repair_calls_the_functions_of_the_program_and_not_those_of_the_model() -> None:
    edit = Edit("double", (("aire(c) + 1", "2 * aire(c) + 1"),), frozenset(("cube",)))
    other = Edit("cote", (("c * c", "c + c"),), frozenset(("aire",)))
    model = Model("def aire(c):\n    return c * c\n\n\ndef cube(c):\n    return aire(c) + 1\n", [edit, other])
    source = "def aire(c):\n    return c + c\n\ndef cube(c):\n    return 2 * aire(c) + 1\n"
    texts = [repair.text for repair in find_repairs(model, "double", ["cube"], source, lambda: False)]
    assert any("return ((aire(c)) + 1)" in text or "return aire(c) + 1" in text for text in texts), texts
    assert not any("_model_" in text for text in texts)
