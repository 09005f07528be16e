"""Whether the cells of the course run: what `balise check` and the course's own test ask."""

from collections.abc import Iterator

from server.cells.run import POLICY, run_cell
from server.cells.schemas import RunOut
from server.course import Course, Problem
from server.course.models import Cell
from server.sandbox import Sandbox


def faults(course: Course) -> Iterator[Problem]:
    """Runs every cell of every lesson as a reader would; a problem for each that fails. Slow; raises SandboxFault."""
    with Sandbox(course.kits, POLICY) as sandbox:
        for module in course.modules.values():
            for lesson in module.lessons:
                path = lesson.text.source.path
                for cell in lesson.cells:
                    shown = run_cell(sandbox, module.slug, cell.code.encode())
                    if message := _fault_message(shown):
                        yield Problem(path, _line(cell, shown), f"cellule « {cell.name} » : {message}")


def _fault_message(shown: RunOut) -> str:
    if shown.fault:
        return shown.fault.message
    if shown.truncated:
        return "ce qu’elle affiche est trop long"
    return "" if shown.stdout or shown.figures else "elle n’affiche rien"


def _line(cell: Cell, shown: RunOut) -> int:
    inside = shown.fault.line if shown.fault else None
    return cell.line + (inside or 1) - 1
