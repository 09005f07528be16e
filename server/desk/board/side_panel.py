"""The statistics beside a board, as their template shows them."""

from __future__ import annotations

from collections.abc import Sequence
from uuid import UUID

from server.board.schemas import (
    FEWEST_FOR_A_CORRELATION,
    FEWEST_FOR_A_SHARE,
    ActivitySlot,
    BoardStatistics,
    ExerciseStats,
    ImprovementStats,
    UnexplainedFailure,
)
from server.desk.board.links import BoardLinks
from server.desk.board.schemas import ActivityBar, ActivityChart, ExerciseRow, SidePanel, UnexplainedRow
from server.desk.views import regrade_href
from server.web.words import format_iso_time, format_points, format_short_time

HEIGHT, BAR, GAP = 60.0, 18.0, 4.0
NO_BREAK_SPACE = "\u00a0"
NO_VALUE = "—"
FEW_STUDENTS = f"moins de {FEWEST_FOR_A_SHARE} élèves"


def side_panel(links: BoardLinks, insights: BoardStatistics, *, may_regrade: bool) -> SidePanel:
    return SidePanel(
        unexplained=_unexplained_rows(links, insights.unnamed),
        improvements=tuple(
            (stats.label, links.title(stats.exercise), share_text(stats))
            for stats in insights.helped
            if stats.share is not None
        ),
        hidden_improvements=sum(stats.share is None for stats in insights.helped),
        hints=tuple(
            (links.title(hints.exercise), tuple(share_text(level) for level in hints.levels))
            for hints in insights.hints
            if any(level.share is not None for level in hints.levels)
        ),
        exercises=tuple(_exercise_row(links, stats, may_regrade=may_regrade) for stats in insights.items),
        charts=(
            _activity_chart("Ces deux dernières heures, par tranche de cinq minutes", insights.lesson, times=True),
            _activity_chart("Ces deux dernières semaines, par jour", insights.days, times=False),
        ),
    )


def _unexplained_rows(links: BoardLinks, failures: Sequence[UnexplainedFailure]) -> tuple[UnexplainedRow, ...]:
    """Return a row for each group, and one for the other failures of each exercise; the most students first."""
    students: dict[tuple[str, str | None], list[UUID]] = {}
    names: dict[tuple[str, str | None], str] = {}
    for failure in failures:
        key = (failure.exercise, failure.group)
        students.setdefault(key, []).extend(failure.students)
        names[key] = failure.name or ""
    rows = [
        UnexplainedRow(
            exercise=links.title(exercise),
            group_href=f"{links.href}/groupes/{exercise}/{group}" if group else "",
            name=names[exercise, group],
            people=links.people(own_students, exercise),
        )
        for (exercise, group), own_students in students.items()
    ]
    return tuple(sorted(rows, key=lambda row: -len(row.people)))


def share_text(stats: ImprovementStats) -> str:
    if stats.share is None:
        return FEW_STUDENTS if stats.n else NO_VALUE
    return f"{_percent(stats.share)} (n = {stats.n})"


def _percent(value: float) -> str:
    return f"{round(100 * value)}{NO_BREAK_SPACE}%"


def _exercise_row(links: BoardLinks, stats: ExerciseStats, *, may_regrade: bool) -> ExerciseRow:
    minutes = stats.median_minutes
    return ExerciseRow(
        title=links.title(stats.exercise),
        href=links.exercise_href(stats.exercise),
        regrade_href=regrade_href(links.href, stats.exercise) if may_regrade else "",
        n=stats.n,
        success=_success_text(stats),
        attempts=number_text(stats.median_attempts),
        minutes=number_text(minutes if minutes is None else round(minutes, 1) if minutes < 10 else round(minutes)),
        discrimination=_discrimination_text(stats),
    )


def _success_text(stats: ExerciseStats) -> str:
    if not stats.n:
        return NO_VALUE
    count = f"{stats.solved} sur {stats.n}"
    return count if stats.success is None else f"{_percent(stats.success)} ({count})"


def number_text(value: float | None) -> str:
    return NO_VALUE if value is None else format_points(value)


def _discrimination_text(stats: ExerciseStats) -> str:
    if stats.paired < FEWEST_FOR_A_CORRELATION:
        return f"moins de {FEWEST_FOR_A_CORRELATION} élèves"
    return NO_VALUE if stats.discrimination is None else f"{format_points(stats.discrimination)} (n = {stats.paired})"


def _activity_chart(title: str, slots: Sequence[ActivitySlot], *, times: bool) -> ActivityChart:
    highest = max((slot.attempts for slot in slots), default=0)
    bars = [_activity_bar(index, slot, highest, times=times) for index, slot in enumerate(slots)]
    width = len(slots) * (BAR + GAP) - GAP
    return ActivityChart(title, tuple(bars), sum(slot.attempts for slot in slots), highest, width)


def _activity_bar(index: int, slot: ActivitySlot, highest: int, *, times: bool) -> ActivityBar:
    height = round(HEIGHT * slot.attempts / highest, 2) if highest else 0.0
    begin = format_iso_time(slot.begins_at) if times else ""
    begin_text = format_short_time(slot.begins_at) if times else slot.begins_at.strftime("%d/%m/%Y")
    return ActivityBar(index * (BAR + GAP), HEIGHT - height, height, slot.attempts, begin, begin_text)
