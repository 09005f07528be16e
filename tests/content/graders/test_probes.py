"""Mistakes recognised by mutants and probes, on a toy whose every mistake is known."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from graders.core.code.call_graph import find_callers
from graders.core.code.diagnosis import lowercase_title
from graders.core.code.evidence import (
    are_all_uninformative,
    are_too_poor_for_two_mistakes,
    has_informative_wrong_answer,
)
from graders.core.code.explaining import MistakeExplainer
from graders.core.code.mutations import Edit, Model
from graders.core.code.pair_search import PairSearch
from graders.core.code.prober import Prober
from graders.core.code.probes import (
    MAX_ITEMS,
    TOO_LARGE,
    ProbeFault,
    ProbeResults,
    Probes,
    measurement_rule,
    read_compared_part,
    same_probe_answer,
)
from graders.core.code.recognised import NamingGround
from graders.core.code.reenacting import Reenactor
from graders.core.code.runner import Runner
from graders.core.code.running import run_checks
from graders.core.contract.local import LOCAL
from graders.core.contract.outcomes import Outcome
from graders.core.contract.program import Reply
from graders.core.contract.streams import stream
from graders.l20 import world
from tests.support.quick import some
from tests.support.shipped import CODE

MODEL = """
def aire(a, b):
    cote = a + 1
    autre = b - 2
    return cote * autre


def double(a, b):
    return 2 * aire(a, b)
"""


def edit(name: str, *texts: str, functions: Sequence[str] = ("aire",)) -> Edit:
    return Edit(name, tuple(zip(texts[::2], texts[1::2], strict=True)), frozenset(functions))


EDITS = (
    edit("plus_deux", "a + 1", "a + 2"),
    edit("b_seul", "b - 2", "b"),
    edit("somme", "cote * autre", "cote + autre"),
    edit("triple", "2 * aire", "3 * aire", functions=["double"]),
    edit("a_seul", "a + 1", "a"),
    Edit("oppose", (("return cote", "return -cote"),)),
)
STYLE = edit("", "cote * autre", "float(cote * autre)")
CALLS = tuple((float(a), float(b)) for a, b in ((1, 5), (2, 7), (4, 3), (0, 9)))


@measurement_rule
def shifted(shown: ProbeResults) -> str | None:
    gaps = {float(a) - float(b) for a, b in zip(shown.got, shown.right, strict=True) if isinstance(a, float)}
    return "decale" if len(gaps) == 1 else None


def prober(**changes: Any) -> Prober:
    common: dict[str, Any] = {"calls": CALLS, "kit": world.STILL, **changes}
    probes = (Probes(function="aire", rules=(shifted,), **common), Probes(function="double", **common))
    return Prober(Model(MODEL, EDITS, (STYLE,)), probes)


PROBER = prober()


def named(
    source: str,
    functions: Sequence[str] = ("aire", "double"),
    asked: Prober = PROBER,
    search: PairSearch | None = None,
) -> tuple[str, ...]:
    runner = Runner(LOCAL, source.encode(), world.STILL)
    try:
        return asked.recognise(runner, functions, functions, search)[0]
    finally:
        runner.close()


def written(cote: str, autre: str, both: str = "{} * {}", double: str = "2 * aire(x, y)") -> str:
    return f"def aire(x, y):\n    return {both.format(cote, autre)}\n\ndef double(x, y):\n    return {double}\n"


@pytest.mark.parametrize(
    ("source", "mistakes"),
    [
        (written("(x + 1)", "(y - 2)"), ()),
        (written("(x + 2)", "(y - 2)"), ("plus_deux",)),
        (written("(x + 2)", "y"), ("plus_deux", "b_seul")),
        (written("(x + 2)", "y", "{} + {}"), ()),  # three at once, and no facet tells two of them
        (written("(x + 1)", "(y - 2)", "{} * {} + 7"), ("decale",)),
        (written("(x + 1)", "(y - 2)", double="3 * aire(x, y)"), ("triple",)),
        (written("(x + 2)", "(y - 2)", double="3 * aire(x, y)"), ("plus_deux", "triple")),
        (written("x ** 3", "y ** 2"), ()),
        (written("(x + 1)", "(y - 2)", "[{} * {}][1]"), ()),
        (
            "def aire(x, y):\n    return -(x + 1) * (y - 2)\n\ndef double(x, y):\n    return 2 * aire(x, y)\n",
            ("oppose",),
        ),
    ],
)
def test_one_mistake_or_two_are_recognised_whatever_the_style(source: str, mistakes: tuple[str, ...]) -> None:
    assert named(source) == mistakes


#: Its `double` does not call its `aire`, which is right, and has the mistake of another one.
APART = "def aire(x, y):\n    return (x + 1) * (y - 2)\n\ndef double(x, y):\n    return 2 * (x + 2) * (y - 2)\n"


def test_no_mistake_of_a_function_that_is_not_blamed_is_named() -> None:
    only_double = Prober(PROBER.model, PROBER.probes[1:])
    assert named(APART, ["double"], only_double) == ()
    assert named(APART, ["aire", "double"], only_double) == ("plus_deux",)


def test_no_mistake_of_a_function_whose_own_answers_are_right_is_named() -> None:
    assert named(APART, ["double"]) == ()
    assert named(APART, ["aire", "double"]) == ()
    assert named(APART.replace("x + 1", "x + 2"), ["aire", "double"]) == ("plus_deux",)


def test_a_facet_tells_three_mistakes_at_once() -> None:
    model = Model("def f(x):\n    return [x + 1, x + 10, x * 5]\n", (
        edit("un", "x + 1,", "x - 1,", functions=["f"]),
        edit("dix", "x + 10", "x - 10", functions=["f"]),
        edit("cinq", "x * 5", "x / 5", functions=["f"]),
    ))  # fmt: skip
    calls = tuple((float(x),) for x in (1, 2, 3))
    source = "def f(x):\n    return (x - 1, x - 10, x / 5)\n"
    whole = Probes(function="f", calls=calls, kit=world.STILL)
    parts = Probes(function="f", calls=calls, kit=world.STILL, facet=lambda args, shown: shown[:2])
    assert named(source, ["f"], Prober(model, [whole])) == ("cinq",)  # by that part alone, whose numbers are not whole
    assert named(source, ["f"], Prober(model, [parts])) == ("un", "dix", "cinq")


def test_edits_that_make_no_program_together_are_not_combined() -> None:
    edits = (
        edit("deux", "return x", "return 2", functions=["f"]),
        edit("reel", " * 3", ".real * 3 + 1", functions=["f"]),
    )
    model = Model("def f(x):\n    return x * 3\n", edits)
    calls = tuple((float(x),) for x in (1, 2, 3))
    asked = Prober(model, [Probes(function="f", calls=calls, kit=world.STILL)])
    assert named("def f(x):\n    return x * 5\n", ["f"], asked) == ()
    assert named("def f(x):\n    return 6\n", ["f"], asked) == ("deux",)


def test_pairs_that_the_verdict_leaves_untried_are_named_after_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("graders.core.code.mutants.MAX_COMBINED_MUTANTS", 1)
    source = written("x", "y")
    assert named(source, asked=prober()) == ()
    every = PairSearch(lambda: False, lambda probes, text: True)
    assert named(source, asked=prober(), search=every) == ("b_seul", "a_seul")
    assert named(source, asked=prober(), search=replace(every, is_time_spent=lambda: True)) == ()
    with monkeypatch.context() as at_once:
        at_once.setattr("graders.core.code.pair_search.MAX_SECONDS", -1.0)
        assert named(source, asked=prober(), search=every) == ()
    assert named(source, asked=prober(), search=replace(every, is_confirmed=lambda probes, text: False)) == ()
    twin = Prober(Model(MODEL, (*EDITS, edit("jumeau", "a + 1", "a + 0")), ()), PROBER.probes)
    assert named(source, asked=twin, search=every) == ()


def test_no_pair_is_searched_for_wrong_answers_that_many_pairs_give() -> None:
    """As a ray that reads the range, which it was given, wherever it should meet a wall."""
    right = [4.0, 9.0, 2.0, 7.0]
    given, none, own = [5.0, 7.0, 3.0, 7.0], [None, 9.0, "texte", 7.0], [5.0, 9.0, 6.0, 7.0]
    assert not has_informative_wrong_answer(ProbeResults(CALLS, given, right))
    assert not has_informative_wrong_answer(ProbeResults(CALLS, none, right))
    assert has_informative_wrong_answer(ProbeResults(CALLS, own, right))


FAULT = ProbeFault("IndexError")


@pytest.mark.parametrize(
    ("got", "silent", "poor"),
    [
        ([FAULT, FAULT, FAULT, FAULT], True, True),
        ([0.0, 0.0, float("nan"), 0.0], True, False),
        ([0.0, 0.0, 0.0, 0.0], True, True),
        ([FAULT, 9.0, FAULT, 7.0], False, True),
        ([1.0, 9.0, 0.0, 7.0], False, True),
        ([5.0, 9.0, 5.0, 7.0], False, False),
        ([5.0, 9.0, 6.0, 7.0], False, False),
        (["illisible", "illisible", 2.0, 7.0], False, True),
    ],
)
def test_answers_that_tell_little(got: list[Any], silent: bool, poor: bool) -> None:
    shown = ProbeResults(CALLS, got, [4.0, 9.0, 2.0, 7.0])
    assert (are_all_uninformative(shown), are_too_poor_for_two_mistakes(shown)) == (silent, poor)


#: By exercise: a mistake that silences a function, and a part of the solution whose change silences it otherwise.
SILENT = {
    "l20/lidar": ("libres_a_l_envers", "def lancer_rayon", "    return 0.0\n"),
    "l20/modele_faisceau": ("carte_de_la_trousse", "def champ_distance", "    [][0]\n"),
}


@pytest.mark.parametrize("exercise", SILENT)
def test_a_mistake_named_on_answers_that_tell_nothing_is_undone_in_the_program(exercise: str) -> None:
    grader = CODE[exercise]
    name, function, silencing = SILENT[exercise]
    (mistake,) = [each for each in grader.misconceptions if each.id == name]
    named = grader.name_mistakes(mistake.source, LOCAL, 3)
    assert named.ids == (name,)
    head, tail = grader.solution.split(function)
    first, rest = tail.split(":\n", 1)
    other_named = grader.name_mistakes(f"{head}{function}{first}:\n{silencing}{rest}", LOCAL, 3)
    assert NamingGround.RESEMBLANCE not in named.grounds.values()
    assert grader.describe_mistakes(named).title == mistake.title
    other = grader.describe_mistakes(other_named)
    assert other.title == f"Peut-être : {lowercase_title(mistake.title)}"
    assert other.explanation.startswith("Votre fonction répond comme avec cette erreur ; d'autres")


@pytest.mark.parametrize(
    ("old", "new", "name"),
    [
        ("tous.mean() > haut", "tous.mean() <= haut", "avis_faux"),
        ("bande(vraies.shape[1], tous.size)", "bande(vraies.shape[0], tous.size)", "avis_faux"),
        ("bande(vraies.shape[1], tous.size)", "bande(tous.size, vraies.shape[1])", "n_et_nombre_echanges"),
    ],
)
def test_a_mistake_named_on_opinions_alone_is_held_against_the_checks(old: str, new: str, name: str) -> None:
    grader = CODE["l19/coherence"]
    source = (grader.folder / "specimens/ok/np_matrix.py").read_text()
    assert old in source
    assert grader.name_mistakes(source.replace(old, new), LOCAL, 3).ids == (name,)


def test_a_pair_holds_where_the_checks_judge_its_program_likewise() -> None:
    grader = CODE["l19/gain"]
    source = grader.solution.replace("v / (v + r)", "v / (v + 2 * r)").encode()
    explainer = MistakeExplainer((), grader.checks, grader.kit, Reenactor())
    runner = Runner(LOCAL, source, grader.kit(stream(3, "kit")))
    run_checks(grader.checks, runner, grader.kit(stream(3, "kit")), 3)
    assert grader.prober is not None
    for probes in grader.prober.probes[:1]:
        assert explainer.is_judged_alike(runner, 3, probes, source.decode())
        assert not explainer.is_judged_alike(runner, 3, probes, grader.solution)
    runner.close()


def test_mistakes_that_look_the_same_leave_what_they_share_or_nothing() -> None:
    twin = (*EDITS, edit("jumeau", "a + 1", "a + 3 - 1"))
    twins = Prober(Model(MODEL, twin, ()), PROBER.probes)
    assert named(written("(x + 2)", "(y - 2)"), asked=twins) == ()
    assert named(written("(x + 2)", "y"), asked=twins) == ("b_seul",)


def test_exceptions_alone_are_not_explained_by_two_mistakes() -> None:
    edits = (edit("nul", "a + 1", "0 * a"), edit("quotient", "cote * autre", "autre / cote"))
    asked = Prober(Model(MODEL, edits), (Probes(function="aire", calls=CALLS, kit=world.STILL),))
    assert named(written("(x + 1)", "(y - 2)", "{1} / {0}"), asked=asked) == ("quotient",)
    assert named(written("(0 * x)", "(y - 2)", "{1} / {0}"), asked=asked) == ()


def test_a_function_that_remembers_is_told_so() -> None:
    source = "seen = []\n" + written("(x + 1 + len(seen))", "(y - 2)").replace(
        "return", "seen.append(1)\n    return", 1
    )
    assert named(source, ["aire"]) == ("memoire",)


@pytest.mark.parametrize("draw", ["rng.normal()", "np.random.default_rng().normal()"])
def test_a_function_that_draws_is_told_apart_from_one_that_remembers(draw: str) -> None:
    assert named(written(f"(x + 1 + {draw})", "(y - 2)"), ["aire"]) == ("hasard",)
    assert named("np.random.seed(3)\n" + written("(x + 1 + np.random.normal())", "(y - 2)"), ["aire"]) == ("memoire",)


def test_a_program_that_is_slow_is_not_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("graders.core.code.prober.MAX_PROBING_SECONDS", -1.0)
    assert named(written("(x + 2)", "(y - 2)")) == ()


ODD = ("None", "'texte'", "[]", "[[1, 2], [3]]", "np.nan", "np.full((3, 3), np.inf)", "10 ** 400", "{}", "(1, 2)",
       "(np.zeros((2, 2)), np.zeros(2))", "([1.0], [[1, 2], [3]])", "np.zeros((2, 0))", "[None, 1]", "1j",
       "[1].pop(3)")  # fmt: skip


def of(exercise: str) -> Prober:
    asked = CODE[exercise].prober
    assert asked is not None
    return asked


def asked_of_odd(prober: Prober) -> None:
    for function in some({probes.function for probes in prober.probes}):
        for odd in ODD:
            functions = sorted(prober.probed_functions)
            source = "\n".join(f"def {name}(*args):\n    return {odd}\n" for name in functions)
            runner = Runner(LOCAL, source.encode(), world.STILL)
            with np.errstate(all="ignore"):
                prober.recognise(runner, [function], [])
            runner.close()


@pytest.mark.parametrize("exercise", CODE)
def test_no_answer_upsets_the_rules_of_an_exercise(exercise: str) -> None:
    """Without its edits, of which hundreds of mutants would be made before a rule is asked."""
    prober = of(exercise)
    asked_of_odd(Prober(replace(prober.model, edits=()), prober.probes))


@pytest.mark.slow
@pytest.mark.parametrize("exercise", CODE)
def test_no_answer_upsets_the_prober_of_an_exercise(exercise: str) -> None:
    asked_of_odd(of(exercise))


@pytest.mark.parametrize("rest", [0, *(pytest.param(k, marks=pytest.mark.slow) for k in (1, 2))])
@pytest.mark.parametrize("exercise", CODE)
def test_every_mistake_that_is_an_edit_is_recognised(exercise: str, rest: int) -> None:
    """One in three in the fast suite, the others in the slow one."""
    grader = CODE[exercise]
    for mistake in some([one for one in grader.misconceptions if not one.whole][rest::3]):
        runner = Runner(LOCAL, mistake.source.encode(), world.STILL)
        found = of(exercise).recognise(runner, mistake.functions, [])
        assert mistake.id in (found.mistakes or found.fallback), mistake.id
        runner.close()


@pytest.mark.parametrize("exercise", CODE)
def test_functions_call_one_another_in_some_version_of_the_model_as_in_the_solution(exercise: str) -> None:
    """Else the wrong answers of a function that calls a wrong one are taken for its own mistake."""
    grader = CODE[exercise]
    versions = [version.text for version in of(exercise).model.correct_versions()]
    for function in grader.functions:
        callers = find_callers(grader.solution.encode(), [function]).intersection(grader.functions)
        assert callers <= frozenset().union(*(find_callers(text.encode(), [function]) for text in versions)), function


@pytest.mark.parametrize("exercise", CODE)
def test_the_solution_answers_the_probes_as_the_model_does(exercise: str) -> None:
    grader = CODE[exercise]
    runner = Runner(LOCAL, grader.solution.encode(), world.STILL)
    with np.errstate(all="ignore"):
        assert of(exercise).recognise(runner, grader.functions, [])[:2] == ((), ())
    runner.close()


@pytest.mark.parametrize("rest", [False, pytest.param(True, marks=pytest.mark.slow)], ids=["one style", "the others"])
@pytest.mark.parametrize("exercise", CODE)
def test_no_right_program_is_named_by_the_probes(exercise: str, rest: bool) -> None:
    """They are asked where a check failed, and it may have failed by something else."""
    programs = honest_programs(exercise)
    if not programs:
        pytest.skip("all its right programs import from their kit")
    for name, text in programs[1:] if rest else programs[:1]:
        runner = Runner(LOCAL, text.encode(), world.STILL)
        with np.errstate(all="ignore"):
            assert of(exercise).recognise(runner, CODE[exercise].functions, [])[:2] == ((), ()), name
        runner.close()


def honest_programs(exercise: str) -> list[tuple[str, str]]:
    """Name and text of the right programs, but for those that import from their kit, which is set in the sandbox."""
    files = [one.path for one in CODE[exercise].specimens() if one.outcome is Outcome.OK]
    programs = [(path.stem, path.read_text("utf-8")) for path in files]
    return [(name, text) for name, text in programs if "from l20" not in text]


def test_what_was_seen_is_the_same_as_itself_only() -> None:
    values: list[Any] = ["a", ["a", np.zeros(2)], np.zeros(2), np.ones(2), None, 1.0, ["a", np.ones(2)]]
    for one in values:
        for other in values:
            assert same_probe_answer(one, other) == (one is other)


def test_of_a_large_answer_nothing_is_kept() -> None:
    for value in (np.zeros(MAX_ITEMS + 1), ["masque", np.zeros(MAX_ITEMS + 1)]):
        assert read_compared_part((), Reply(value), lambda args, value: value) == TOO_LARGE
