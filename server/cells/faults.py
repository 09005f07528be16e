"""Whether the cells of the course run: what `balise check` and the course's own test ask."""

from collections.abc import Iterator

from server.cells.run import POLICY, run_cell
from server.cells.schemas import CellRunResult
from server.course import Course, Problem
from server.course.models import CodeCell
from server.sandbox import Sandbox


def find_failing_cells(course: Course) -> Iterator[Problem]:
    """Runs every cell of every lesson as a reader would; a problem for each that fails. Slow; raises SandboxFault."""
    with Sandbox(course.kits, POLICY) as sandbox:
        for module in course.modules.values():
            for lesson in module.lessons:
                path = lesson.text.source.path
                for cell in lesson.cells:
                    shown = run_cell(sandbox, module.slug, cell.code.encode())
                    if message := _failure_message(shown):
                        yield Problem(
                            path, _source_line_of_failure(cell, shown), f"cellule « {cell.name} » : {message}"
                        )


def _failure_message(run: CellRunResult) -> str:
    if run.fault:
        return run.fault.message
    if run.truncated:
        return "ce qu’elle affiche est trop long"
    return "" if run.stdout or run.figures else "elle n’affiche rien"


def _source_line_of_failure(cell: CodeCell, run: CellRunResult) -> int:
    inside = run.fault.line if run.fault else None
    return cell.line + (inside or 1) - 1
