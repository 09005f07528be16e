"""The verdict's JSON: read strictly, written back as it was, the same for whoever reads it."""

from __future__ import annotations

import copy
import dataclasses
import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from graders.core.contract.outcomes import Outcome
from graders.core.contract.verdict import (
    MAX_POINTS,
    TEACHER,
    CheckResult,
    Counterexample,
    Diagnosis,
    MalformedVerdictError,
    Verdict,
    internal_error_verdict,
)
from server.api.schemas import CheckOut, CounterexampleOut, DiagnosisOut, VerdictOut
from tests.support.tables import folded

#: Written by the version f36e32d, one for each outcome at least; what is stored must be readable for ever.
STORED: dict[str, dict[str, Any]] = json.loads(
    (Path(__file__).parent / "samples" / "verdicts.json").read_text(encoding="utf-8")
)
PASSED = CheckResult("a", "A", True, 8, 8)
FAILED = CheckResult("b", "B", False, 3.5, 12)


def wrong(**changes: Any) -> Verdict:
    return dataclasses.replace(Verdict("l20/x", "v", Outcome.WRONG_ANSWER, 1, [PASSED, FAILED]), **changes)


@pytest.mark.parametrize("name", STORED)
def test_what_was_stored_is_read_and_written_back_to_the_letter(name: str) -> None:
    verdict = Verdict.from_json(STORED[name])
    assert json.dumps(verdict.to_json()) == json.dumps(STORED[name])
    assert name not in set(Outcome) or verdict.outcome.value == name


def test_the_samples_hold_every_outcome_that_there_was() -> None:
    assert {stored["outcome"] for stored in STORED.values()} == set(Outcome)


plain = st.recursive(
    st.none() | st.booleans() | st.integers(-(2**53), 2**53) | st.floats(allow_nan=False, allow_infinity=False)
    | st.text(),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(), inner, max_size=4),
    max_leaves=12,
)  # fmt: skip
examples = st.builds(Counterexample, st.dictionaries(st.text(), plain, max_size=3), plain, plain)


@st.composite
def checks(draw: Any) -> tuple[CheckResult, ...]:
    """Checks whose points sum to 20, in quarters of a point."""
    cuts = sorted(draw(st.sets(st.integers(1, 79), max_size=5)))
    made = []
    for low, high in zip([0, *cuts], [*cuts, 80], strict=True):
        most, passed = (high - low) / 4, draw(st.booleans())
        points = most if passed else draw(st.integers(0, high - low - 1)) / 4
        example, hint, figure = draw(st.none() | examples), draw(st.none() | st.text()), draw(st.none() | st.text())
        made.append(CheckResult(draw(st.text()), draw(st.text()), passed, points, most, "m", example, hint, figure))
    return tuple(made)


@st.composite
def verdicts(draw: Any) -> Verdict:
    results = draw(checks())
    failing = [outcome for outcome in Outcome if outcome is not Outcome.OK]
    outcome = Outcome.OK if all(one.passed for one in results) else draw(st.sampled_from(failing))
    diagnosis = draw(st.none() | st.builds(Diagnosis, st.text(), st.text(), st.text()))
    timings = draw(st.dictionaries(st.text(), st.floats(0, 1e6), max_size=3))
    seed = draw(st.integers(0, 2**53))
    remarks, error = draw(st.lists(st.text(), max_size=2)), draw(st.text())
    stdout = draw(st.text())
    return Verdict(draw(st.text()), draw(st.text()), outcome, seed, results, diagnosis, stdout, timings, remarks, error)


@given(verdicts())
def test_reading_undoes_writing(verdict: Verdict) -> None:
    text = json.dumps(verdict.to_json(), allow_nan=False)
    read = Verdict.from_json(json.loads(text))
    assert read == verdict
    assert json.dumps(read.to_json()) == text
    VerdictOut.model_validate(verdict.to_json(), strict=False)


def places(value: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """The place of every member that the contract names: not those inside of a counterexample's values."""
    if isinstance(value, dict) and path[-1:] not in (("inputs",), ("expected",), ("got",)):
        for key, item in value.items():
            yield (*path, key)
            yield from places(item, (*path, key))
    elif isinstance(value, list) and path == ("checks",):
        for index, item in enumerate(value):
            yield from places(item, (*path, index))


def changed(path: tuple[Any, ...], change: Callable[[Any, Any], None]) -> Any:
    verdict = copy.deepcopy(STORED["wrong_answer"])
    holder = verdict
    for part in path[:-1]:
        holder = holder[part]
    change(holder, path[-1])
    return verdict


MEMBERS = list(places(STORED["wrong_answer"]))


@folded("path", MEMBERS, ids=lambda path: "/".join(map(str, path)))
def test_what_is_missing_or_of_another_type_is_told_with_its_place(path: tuple[Any, ...]) -> None:
    place = "/".join(map(str, path))
    if path[0] != "timings" or len(path) == 1:
        with pytest.raises(MalformedVerdictError) as lacking:
            Verdict.from_json(changed(path, lambda holder, name: holder.pop(name)))
        assert (lacking.value.place, lacking.value.reason) == (place, "is missing")
    if path[-1] not in ("expected", "got"):
        with pytest.raises(MalformedVerdictError) as other:
            Verdict.from_json(changed(path, lambda holder, name: holder.update({name: (1,)})))
        assert other.value.place == place


@pytest.mark.parametrize("path", [(), ("checks", 1), ("checks", 1, "counterexample"), ("diagnosis",)])
def test_what_is_unknown_is_told_with_its_place(path: tuple[Any, ...]) -> None:
    with pytest.raises(MalformedVerdictError, match="is not expected") as extra:
        Verdict.from_json(changed((*path, "zut"), lambda holder, name: holder.update({name: 1})))
    assert extra.value.place == "/".join(map(str, (*path, "zut")))


@pytest.mark.parametrize(
    ("change", "place"),
    [
        ({"outcome": "melted"}, "outcome"),
        ({"outcome": "ok"}, "outcome"),
        ({"score": 0.9}, "score"),
        ({"points": 19}, "points"),
        ({"max_points": 10}, "max_points"),
        ({"seed": True}, "seed"),
        ({"seed": 1.0}, "seed"),
        ({"checks": {}}, "checks"),
        ({"checks": []}, "outcome"),
        ({"timings": {"total_ms": float("nan")}}, "timings/total_ms"),
        ({"stdout": None}, "stdout"),
    ],
)
def test_what_contradicts_itself_is_no_verdict(change: dict[str, Any], place: str) -> None:
    with pytest.raises(MalformedVerdictError) as error:
        Verdict.from_json({**STORED["wrong_answer"], **change})
    assert error.value.place == place


@pytest.mark.parametrize("value", [None, [], "ok", 3, float("nan")])
def test_what_is_no_object_is_no_verdict(value: Any) -> None:
    with pytest.raises(MalformedVerdictError):
        Verdict.from_json(value)


@pytest.mark.parametrize("value", [float("nan"), float("inf"), (1,), {1: 2}, b"x", {"a": [object()]}])
def test_a_counterexample_is_strict_json(value: Any) -> None:
    with pytest.raises(MalformedVerdictError):
        Verdict.from_json(
            changed(("checks", 0, "counterexample"), lambda holder, name: holder[name].update({"got": value}))
        )


def test_a_verdict_that_its_checks_do_not_bear_out_cannot_be_made() -> None:
    for build in (
        lambda: wrong(outcome=Outcome.OK),
        lambda: wrong(outcome=Outcome.OK, checks=[PASSED]),
        lambda: wrong(outcome=Outcome.OK, checks=[]),
        lambda: wrong(checks=[]),
        lambda: wrong(checks=[CheckResult("a", "A", True, 20, 20)]),
        lambda: wrong(outcome=Outcome.INTERNAL_ERROR, checks=[CheckResult("a", "A", True, 20, 20)]),
        lambda: wrong(checks=[FAILED, CheckResult("a", "A", True, 20, 20)]),
        lambda: CheckResult("a", "A", True, 7, 8),
        lambda: CheckResult("a", "A", False, 8, 8),
        lambda: CheckResult("a", "A", False, -1, 8),
        lambda: CheckResult("a", "A", False, 9, 8),
    ):
        with pytest.raises(ValueError, match=r"outcome|points"):
            build()
    assert wrong().points == 11.5
    assert internal_error_verdict("l20/x", "v", 1).checks == ()
    assert wrong(outcome=Outcome.OK, checks=[CheckResult("a", "A", True, MAX_POINTS, MAX_POINTS)]).score == 1.0


@pytest.mark.parametrize(
    ("documented", "written"),
    [
        (
            VerdictOut,
            dataclasses.replace(Verdict.from_json(STORED["wrong_answer"]), remarks=["r"], load_error="e").to_json(),
        ),
        (
            CheckOut,
            CheckResult(
                "a", "A", False, 0, 8, cause=Outcome.TIMEOUT, repeats="b", neutral=True, kit={"seed": 1}, case="c"
            ).to_json(),
        ),
        (CounterexampleOut, STORED["wrong_answer"]["checks"][0]["counterexample"]),
        (DiagnosisOut, Diagnosis("a", "A", "Ainsi.", TEACHER, (("b",),), certain=True).to_json()),
    ],
    ids=lambda value: getattr(value, "__name__", ""),
)
def test_the_api_documents_the_members_that_are_written(documented: Any, written: dict[str, Any]) -> None:
    assert list(documented.model_fields) == list(written)


@pytest.mark.parametrize("name", STORED)
def test_the_api_documents_what_is_written(name: str) -> None:
    read = VerdictOut.model_validate_json(json.dumps(STORED[name]))
    assert json.loads(read.model_dump_json(exclude_unset=True)) == STORED[name]


def test_a_diagnosis_says_that_it_is_a_teacher_s() -> None:
    told = Diagnosis("a", "A", "Ainsi.", TEACHER)
    assert told.to_json() == {"id": "a", "title": "A", "explanation": "Ainsi.", "source": "teacher"}
    assert Diagnosis.from_json(told.to_json()) == told
    assert "source" not in Diagnosis("a", "A", "Ainsi.").to_json()


def test_nothing_is_said_to_be_expected_where_a_program_stopped_and_nothing_was_compared() -> None:
    assert not Counterexample({"z": 1}, None, "aucune valeur (ZeroDivisionError)").has_expected
    assert Counterexample({"z": 1}, [2.0], "aucune valeur (ZeroDivisionError)").has_expected
    assert Counterexample({"z": 1}, None, [2.0]).has_expected
