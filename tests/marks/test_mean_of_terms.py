"""A student's mean: weights, states, bonuses, against an oracle that counts with fractions."""

from __future__ import annotations

import math
from fractions import Fraction

from hypothesis import given
from hypothesis import strategies as st

from server.marks.means import FULL_POINTS, MeanTerm, mean_of_terms
from server.marks.schemas import ColumnMark, ColumnRecord, TypedMark
from server.marks.states import UNMARKED_STATES, Counting, MarkingRules, MarkState, TypedState

points = st.one_of(st.none(), st.floats(0, 20))
weights = st.one_of(st.sampled_from([0.0, 0.5, 1.0, 2.0]), st.floats(0, 1000, allow_subnormal=False))
terms = st.builds(MeanTerm, points, weights, st.booleans())
many = st.lists(terms, max_size=8)
rules = st.builds(MarkingRules, *[st.sampled_from(Counting)] * 4)


def oracle(listed: list[MeanTerm]) -> Fraction | None:
    """The same by the definition, with exact numbers."""
    counted = [(Fraction(term.points), Fraction(term.weight), term.bonus) for term in listed if term.points is not None]
    total = sum((weight for _, weight, bonus in counted if not bonus), Fraction(0))
    if total == 0:
        return None
    base = sum((value * weight for value, weight, bonus in counted if not bonus), Fraction(0)) / total
    return min(Fraction(20), base + sum((value for value, _, bonus in counted if bonus), Fraction(0)))


@given(many)
def test_a_mean_is_that_of_fractions(listed: list[MeanTerm]) -> None:
    found, exact = mean_of_terms(listed), oracle(listed)
    assert (found is None) == (exact is None)
    if found is not None and exact is not None:
        assert math.isclose(found, exact, rel_tol=1e-12, abs_tol=1e-12)
        assert 0 <= found <= FULL_POINTS + 1e-9


@given(many, st.randoms())
def test_the_order_does_not_matter(listed: list[MeanTerm], random: object) -> None:
    mixed = [*listed]
    random.shuffle(mixed)  # type: ignore[attr-defined]
    assert mean_of_terms(mixed) == mean_of_terms(listed)


@given(many, st.floats(0, 20), weights)
def test_a_bonus_never_lowers(listed: list[MeanTerm], value: float, weight: float) -> None:
    without, more = mean_of_terms(listed), mean_of_terms([*listed, MeanTerm(value, weight, bonus=True)])
    assert (without is None) == (more is None)
    assert without is None or more is None or more >= without


@given(many, weights, st.booleans())
def test_what_does_not_count_changes_nothing(listed: list[MeanTerm], weight: float, bonus: bool) -> None:
    assert mean_of_terms([*listed, MeanTerm(None, weight, bonus)]) == mean_of_terms(listed)


@given(many, st.floats(0, 20), st.sampled_from([0.5, 1.0, 3.0]))
def test_a_mark_pulls_the_mean_towards_it(listed: list[MeanTerm], value: float, weight: float) -> None:
    plain = [term for term in listed if not term.bonus]
    before, after = mean_of_terms(plain), mean_of_terms([*plain, MeanTerm(value, weight)])
    assert after is not None
    low, high = sorted((value, value if before is None else before))
    assert low - 1e-9 <= after <= high + 1e-9


@given(rules, st.sampled_from(MarkState))
def test_excused_and_not_due_never_count(chosen: MarkingRules, state: MarkState) -> None:
    counted = chosen.points_without_mark(state)
    assert counted in {None, 0.0}
    if state not in UNMARKED_STATES:
        assert counted is None
    else:
        assert (counted == 0.0) == (getattr(chosen, state.value) is Counting.zero)


@given(rules, st.sampled_from([5.0, 10.0, 20.0, 40.0]), st.booleans(), st.floats(0, 1), st.sampled_from(TypedState))
def test_a_column_counts_on_its_scale_or_by_its_state(
    chosen: MarkingRules, out_of: float, bonus: bool, share: float, state: TypedState
) -> None:
    column = ColumnRecord(id=None, title="Oral", out_of=out_of, taken_on=None, weight=1.0, bonus=bonus,  # type: ignore[arg-type]
                          published_at=None, version=1)  # fmt: skip
    value = share * out_of
    counted = ColumnMark(column, TypedMark(value), chosen).points_in_average
    assert counted is not None
    assert math.isclose(counted, value if bonus else 20 * share, abs_tol=1e-9)
    by_state = ColumnMark(column, TypedMark(state=state), chosen).points_in_average
    assert by_state == chosen.points_without_mark(MarkState(state.value))
    assert ColumnMark(column, TypedMark(), chosen).points_in_average is None
