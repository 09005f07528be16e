"""The state of an assignment and what it counts, for whatever was sent and set: against their definition in words."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta
from fractions import Fraction
from uuid import UUID

from hypothesis import given
from hypothesis import strategies as st

from server.assignments.counting import AttemptMark
from server.assignments.models import Assignment, LatePolicy, Mode
from server.assignments.rules import rules_in_force
from server.marks.marking import compute_mark_state
from server.marks.schemas import ActiveOverride, AssignmentMark, ExerciseMark
from server.marks.states import UNMARKED_STATES, Counting, MarkingRules, MarkState

OPENS, DUE = datetime(2026, 3, 2, tzinfo=UTC), datetime(2026, 3, 9, tzinfo=UTC)
ID = UUID(int=1)
ASSIGNMENT = Assignment(
    id=ID, class_id=ID, title="DM", mode=Mode.practice, opens_at=OPENS, due_at=DUE, late=LatePolicy.refuse, weight=1.0,
    counts="best",
)  # fmt: skip
RULES = rules_in_force(ASSIGNMENT, (), ID, ())

scores = st.integers(0, 80).map(lambda quarters: quarters / 4)
overrides = st.one_of(
    st.none(),
    st.builds(lambda points: ActiveOverride(points, points is None, "", "", OPENS, frozenset()), st.none() | scores),
)


@st.composite
def exercise_marks(draw: st.DrawFn) -> ExerciseMark:
    points, sent = draw(st.none() | scores), draw(st.integers(0, 3))
    counted = None if points is None else AttemptMark(ID, points, points, 0)
    return ExerciseMark(
        "l20/poses", draw(st.sampled_from([0.5, 1.0, 3.0])), counted, None, OPENS, 0 if points is None else 1,
        draw(overrides), max(sent, 1) if points is not None else sent,
    )  # fmt: skip


@given(
    st.lists(exercise_marks(), min_size=1, max_size=4),
    st.sampled_from([OPENS - timedelta(days=1), OPENS, DUE, DUE + timedelta(seconds=1)]),
    st.builds(MarkingRules, *[st.sampled_from(Counting)] * 4),
)
def test_a_state_is_what_its_word_says(marks: list[ExerciseMark], now: datetime, chosen: MarkingRules) -> None:
    state = compute_mark_state(RULES, marks, now)
    mark = AssignmentMark(RULES, state, tuple(marks), marking=chosen)
    has_points = any(one.points is not None for one in marks)
    assert (state is MarkState.excused) == all(one.excused for one in marks)
    if state is not MarkState.excused:
        assert (state is MarkState.upcoming) == (now < OPENS)
        assert (state is MarkState.open) == (OPENS <= now <= DUE)
        assert (state is MarkState.done) == (now > DUE and has_points)
        assert (state is MarkState.late_refused) == (
            now > DUE and not has_points and any(one.is_refused_as_late for one in marks)
        )
    if now <= DUE or state is MarkState.excused:
        assert mark.points_in_average is None, "neither excused nor not due yet counts"
    elif state in UNMARKED_STATES:
        assert mark.points_in_average == (0.0 if getattr(chosen, state.value) is Counting.zero else None)
    else:
        asked = [one for one in marks if not one.excused]
        if chosen.unanswered is Counting.ignore:
            asked = [one for one in asked if one.points is not None]
        total = sum(Fraction(one.weight) for one in asked)
        exact = sum(Fraction(one.points or 0.0) * Fraction(one.weight) for one in asked) / total
        assert mark.points_in_average is not None
        assert abs(mark.points_in_average - exact) < 1e-9


@given(st.lists(exercise_marks(), min_size=1, max_size=4), st.floats(0, 20))
def test_an_excused_exercise_changes_no_points(marks: list[ExerciseMark], points: float) -> None:
    excused = ExerciseMark(
        "l20/kabsch", 9.0, AttemptMark(ID, points, points, 0), None, OPENS, 1,
        ActiveOverride(None, True, "", "", OPENS, frozenset()), 1,
    )  # fmt: skip
    late = DUE + timedelta(days=1)
    before, after = ([*marks, *more] for more in ((), (excused,)))
    states = [compute_mark_state(RULES, listed, late) for listed in (before, after)]
    assert states[0] == states[1]
    shown = [
        AssignmentMark(RULES, state, tuple(listed)).points
        for state, listed in zip(states, (before, after), strict=True)
    ]
    assert shown[0] == shown[1]
