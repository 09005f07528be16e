"""Changes of an open board, as server-sent events that hold HTML."""

from __future__ import annotations

import json
from dataclasses import dataclass

from server.base import root_path
from server.board.schemas import Board
from server.course import Course
from server.desk.board.links import BoardLinks
from server.desk.board.views import cell_key, render_cell, render_counts, render_misconceptions
from server.submissions.job_events import format_sse

#: Sent to a page that shows another version than the changes begin from, or other rows than the class has.
OUTDATED = "outdated"


@dataclass(frozen=True)
class OpenBoard:
    """A page in a browser: `version` is that of the board it shows; `everything`: it shows all misconceptions."""

    course: Course
    href: str
    version: str
    everything: bool


def board_events(page: OpenBoard, before: Board | None, board: Board) -> str:
    """Return the events that lead from `before` to `board`; without `before`, from what the page shows."""
    if before is None:
        events = [] if page.version == board.version else [(OUTDATED, "")]
    elif (before.list_shown_students, before.exercises) != (board.list_shown_students, board.exercises):
        events = [(OUTDATED, "")]
    else:
        events = _board_change_events(page, before, board)
    # The id comes last: a browser that lost some of this begins again from before it.
    return (
        "".join(format_sse(name, text) for name, text in events)
        + f"id: {board.version}\n"
        + format_sse("version", board.version)
    )


def _board_change_events(page: OpenBoard, before: Board, board: Board) -> list[tuple[str, str]]:
    events = []
    for cell in board.cells_changed_since(before):
        html = root_path.with_external_paths(render_cell(page.href, board, cell))
        events.append(("cell", json.dumps({"key": cell_key(cell.student, cell.exercise), "html": html})))
    if before.counts != board.counts:
        events.append(("counts", root_path.with_external_paths(render_counts(board))))
    if before.misconceptions != board.misconceptions:
        links = BoardLinks(page.course, page.href, board.students)
        rows = render_misconceptions(links, board, everything=page.everything)
        events.append(("misconceptions", root_path.with_external_paths(rows)))
    return events
