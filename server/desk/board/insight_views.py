"""What is read beside a board, in words and drawings: unnamed failures, what helped, exercises, the time line."""

from __future__ import annotations

from collections.abc import Sequence
from uuid import UUID

from server.board.schemas import (
    FEWEST_FOR_A_CORRELATION,
    FEWEST_FOR_A_SHARE,
    ActivitySlot,
    ExerciseStats,
    HintStats,
    ImprovementStats,
    Insights,
    UnexplainedFailure,
)
from server.desk.board.schemas import BarView, ChartView, HelpedRow, ItemView, UnnamedView
from server.desk.board.shown import Shown
from server.desk.views import regrade_href
from server.web.words import moment, moment_text, points

HEIGHT, BAR, GAP = 60.0, 18.0, 4.0
NO_BREAK = "\u00a0"
NOTHING = "—"
FEW = f"moins de {FEWEST_FOR_A_SHARE} élèves"


def unnamed(shown: Shown, found: Sequence[UnexplainedFailure]) -> tuple[UnnamedView, ...]:
    """A row for each group; failures that stand alone share that of their exercise."""
    rows: dict[tuple[str, str | None], list[UUID]] = {}
    names: dict[tuple[str, str | None], str] = {}
    for one in found:
        key = (one.exercise, one.group)
        rows.setdefault(key, []).extend(one.students)
        names[key] = one.name or ""
    views = [
        UnnamedView(
            exercise=shown.title(exercise),
            exercise_href=shown.exercise_href(exercise),
            group_href=f"{shown.href}/groupes/{exercise}/{group}" if group else "",
            name=names[exercise, group],
            people=shown.people(students, exercise),
        )
        for (exercise, group), students in rows.items()
    ]
    return tuple(sorted(views, key=lambda view: -len(view.people)))


def helped(shown: Shown, found: Sequence[ImprovementStats]) -> tuple[HelpedRow, ...]:
    """Of misconceptions that enough students have met."""
    return tuple(
        HelpedRow(one.label, shown.title(one.exercise), (share(one),)) for one in found if one.share is not None
    )


def hints(shown: Shown, found: Sequence[HintStats]) -> tuple[HelpedRow, ...]:
    """Of exercises where one hint at least has opened to enough students."""
    return tuple(
        HelpedRow(shown.title(one.exercise), "", tuple(share(level) for level in one.levels))
        for one in found
        if any(level.share is not None for level in one.levels)
    )


def share(one: ImprovementStats) -> str:
    if one.share is None:
        return FEW if one.n else NOTHING
    return f"{percent(one.share)} (n = {one.n})"


def percent(value: float) -> str:
    return f"{round(100 * value)}{NO_BREAK}%"


def items(shown: Shown, found: Sequence[ExerciseStats], *, may_regrade: bool) -> tuple[ItemView, ...]:
    return tuple(
        ItemView(
            exercise=shown.title(one.exercise),
            href=shown.exercise_href(one.exercise),
            regrade_href=regrade_href(shown.href, one.exercise) if may_regrade else "",
            n=one.n,
            success=_success(one),
            attempts=_or_nothing(one.median_attempts),
            minutes=_or_nothing(None if one.median_minutes is None else _minutes(one.median_minutes)),
            discrimination=_discrimination(one),
        )
        for one in found
    )


def _success(one: ExerciseStats) -> str:
    if not one.n:
        return NOTHING
    return f"{one.solved} sur {one.n}" if one.success is None else f"{percent(one.success)} ({one.solved} sur {one.n})"


def _minutes(value: float) -> float:
    return round(value, 1) if value < 10 else round(value)


def _or_nothing(value: float | None) -> str:
    return NOTHING if value is None else points(value)


def _discrimination(one: ExerciseStats) -> str:
    if one.paired < FEWEST_FOR_A_CORRELATION:
        return f"moins de {FEWEST_FOR_A_CORRELATION} élèves"
    return NOTHING if one.discrimination is None else f"{points(one.discrimination)} (n = {one.paired})"


def charts(insights: Insights) -> tuple[ChartView, ...]:
    return (
        _chart("Ces deux dernières heures, par tranche de cinq minutes", insights.lesson, times=True),
        _chart("Ces deux dernières semaines, par jour", insights.days, times=False),
    )


def _chart(title: str, slots: Sequence[ActivitySlot], *, times: bool) -> ChartView:
    most = max((slot.attempts for slot in slots), default=0)
    bars = [_bar(place, slot, most, times=times) for place, slot in enumerate(slots)]
    width = len(slots) * (BAR + GAP) - GAP
    return ChartView(title, tuple(bars), sum(slot.attempts for slot in slots), most, width, times)


def _bar(place: int, slot: ActivitySlot, most: int, *, times: bool) -> BarView:
    height = round(HEIGHT * slot.attempts / most, 2) if most else 0.0
    when = moment_text(slot.begins_at) if times else slot.begins_at.strftime("%d/%m/%Y")
    return BarView(
        place * (BAR + GAP), HEIGHT - height, height, slot.attempts, moment(slot.begins_at) if times else "", when
    )
