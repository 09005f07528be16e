"""l20/poses: honest styles pass on every seed, every catalogued mistake is named, figures draw."""

import json
from functools import partial
from typing import Any

import pytest

from graders.core.code.isolation import solution_override_suffix
from graders.core.contract.local import LOCAL
from graders.plotting import counterexample
from tests.support.quick import THEMES, one_in
from tests.support.shipped import CODE
from tests.support.verdicts import model_with, verdict_of

GRADER = CODE["l20/poses"]
verdict = partial(verdict_of, GRADER.exercise)

SEEDS = range(10)


@pytest.mark.parametrize("seed", SEEDS)
def test_the_solution_gets_full_marks(seed: int) -> None:
    assert verdict(GRADER.solution, seed).score == 1.0


@pytest.mark.parametrize(
    "path", one_in(8, sorted((GRADER.folder / "specimens/ok").glob("*.py"))), ids=lambda path: path.stem
)
def test_honest_styles_pass(path: Any) -> None:
    """On two seeds; on thirty, in `test_variety.py`."""
    source = path.read_text(encoding="utf-8").replace("from l20 import np as numpy", "numpy = np")
    for seed in range(2):
        assert verdict(source, seed).score == 1.0


def test_the_counterexample_of_a_forgotten_rotation_is_a_quarter_turn() -> None:
    mistake = next(m for m in GRADER.misconceptions if m.id == "rotation_oubliee")
    counterexample = verdict(mistake.source, 3).checks[0].counterexample
    assert counterexample.inputs["a"][:2] == [0.0, 0.0]
    assert counterexample.inputs["a"][2] == pytest.approx(1.5707963267948966)
    assert sorted(map(abs, counterexample.inputs["b"])) == [0.0, 0.0, 1.0]


def test_a_third_mistake_that_changes_nothing_is_not_named() -> None:
    source = model_with(
        GRADER.exercise,
        "return np.pi - (np.pi - angle) % (2 * np.pi)", "return np.fmod(angle + np.pi, 2 * np.pi) - np.pi",
        "tb = b\n    c, s = np.cos(-ta), np.sin(-ta)", "tb = b\n    c, s = np.cos(-tb), np.sin(-tb)",
    )  # fmt: skip
    beside_right_ones = source + solution_override_suffix(GRADER, source, ["composer", "inverse"])
    assert set(GRADER.name_mistakes(beside_right_ones, LOCAL, 3).ids) == {"relatif_cap_de_b", "ramene_d_un_seul_cote"}


def test_two_mistakes_of_one_function_that_are_not_found_in_it_are_told_as_a_resemblance() -> None:
    """A position that is conjugated too answers as two mistakes of the catalogue together."""
    source = model_with(
        GRADER.exercise,
        "u = -(c * x - s * y)", "autre = -complex(x, y) * complex(np.cos(t), np.sin(t))\n    u = autre.real",
        "v = -(s * x + c * y)", "v = -autre.imag",
    )  # fmt: skip
    diagnosis = verdict(source, 3).diagnosis
    assert diagnosis is not None
    assert all(title.casefold().startswith("peut-être") for title in diagnosis.titles)


@pytest.mark.parametrize("theme", THEMES)
def test_figures_draw(theme: str) -> None:
    mistake = next(m for m in GRADER.misconceptions if m.id == "degres_dans_cos")
    figures = json.loads(json.dumps(GRADER.grade(mistake.source.encode(), LOCAL, seed=1, version="v").figures))
    for check in ("composer_exemples", "relatif")[theme == "light" :]:  # both have one kind
        assert counterexample(GRADER.exercise, figures[check], theme=theme).startswith(b"<?xml")
