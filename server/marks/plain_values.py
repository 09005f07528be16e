"""The gradebook and its parts as plain values (contract, section 6)."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from server.assignments.models import Assignment, Mode
from server.marks.means import round_or_none
from server.marks.schemas import (
    ActiveDecision,
    AssignmentMark,
    ColumnMark,
    ExerciseMark,
    Gradebook,
    MarkStatistics,
    is_test_withheld,
)
from server.marks.states import MarkState


def gradebook_json(gradebook: Gradebook) -> dict[str, Any]:
    """Return the whole gradebook as plain values (contract, section 6)."""
    school_class = gradebook.school_class
    return {
        "class": {"id": school_class.id, "name": school_class.name, "module": school_class.module},
        "generated_at": gradebook.at,
        "marking": asdict(gradebook.marking),
        "assignments": [_assignment_json(gradebook, index) for index in range(len(gradebook.assignments))],
        "columns": [
            {**asdict(column), **_summary_json(gradebook.column_statistics(index))}
            for index, column in enumerate(gradebook.columns)
        ],
        "students": [
            {
                "id": row.member.id,
                "name": row.member.name,
                "groups": list(row.member.groups),
                "average": round_or_none(row.average),
                "marks": [
                    _assignment_mark_json(assignment, mark)
                    for assignment, mark in zip(gradebook.assignments, row.marks, strict=True)
                ],
                "columns": [column_mark_json(mark) for mark in row.columns],
            }
            for row in gradebook.rows
        ],
    }


def _assignment_json(gradebook: Gradebook, index: int) -> dict[str, Any]:
    assignment, summary = gradebook.assignments[index], gradebook.assignment_statistics(index)
    return {
        "id": assignment.id,
        "title": assignment.title,
        "mode": Mode(assignment.mode),
        "weight": assignment.weight,
        "opens_at": assignment.opens_at,
        "due_at": assignment.due_at,
        "closes_at": assignment.closes_at,
        "held_back": is_test_withheld(assignment, gradebook.at),
        "exercises": [
            {"exercise": exercise, "weight": weight} for exercise, weight in gradebook.exercises[assignment.id]
        ],
        "copies": summary.count,
        "mean": round_or_none(summary.mean),
        "median": round_or_none(summary.median),
    }


def _summary_json(summary: MarkStatistics) -> dict[str, Any]:
    rounded = (None if value is None else round(value, 2) for value in (summary.mean, summary.median))
    return dict(zip(("copies", "mean", "median"), (summary.count, *rounded), strict=True))


def column_mark_json(mark: ColumnMark) -> dict[str, Any]:
    """`points` are out of the column's own scale, `counted` out of 20."""
    return {
        "column": mark.column.id,
        "state": mark.state,
        "points": mark.typed.points,
        "counted": mark.points_in_average,
        "comment": mark.typed.comment,
        "version": mark.typed.version,
    }


def _assignment_mark_json(assignment: Assignment, mark: AssignmentMark) -> dict[str, Any]:
    return {
        "assignment": assignment.id,
        "state": mark.state,
        "points": round_or_none(mark.points),
        "counted": round_or_none(mark.points_in_average),
        "days_late": mark.days_late,
        "exercises": [exercise_mark_json(exercise, mark.state) for exercise in mark.exercises],
        "decision": None if mark.decision is None else decision_json(mark.decision),
    }


def decision_json(decision: ActiveDecision) -> dict[str, Any]:
    return {"state": decision.state, "reason": decision.reason, "by": decision.by or None, "at": decision.at}


def exercise_mark_json(mark: ExerciseMark, assignment_state: MarkState | None = None) -> dict[str, Any]:
    """`assignment_state`: of the assignment in which it is; None where no assignment asks the exercise."""
    override = mark.override
    return {
        "exercise": mark.exercise,
        "state": None if assignment_state is None else mark.state_within(assignment_state),
        "points": round_or_none(mark.points),
        "automatic": round_or_none(mark.effective.automatic),
        "excused": mark.excused,
        "days_late": mark.days_late,
        "attempts": mark.attempts,
        "override": None
        if override is None
        else {
            "points": round_or_none(override.points),
            "excused": override.excused,
            "reason": override.reason,
            "assignment": override.assignment_id,
            "by": override.by or None,
            "at": override.at,
            "stale": mark.stale,
        },
    }
