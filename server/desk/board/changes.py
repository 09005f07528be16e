"""What changes on the page of a board while it is looked at, as server-sent events that hold HTML."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any

from server.base import root
from server.board.schemas import Board
from server.course import Course
from server.desk.board.schemas import CountsView
from server.desk.board.shown import ShownBoard
from server.desk.board.views import cell_html, key_of, mistake_rows
from server.submissions.events import sse
from server.web.rendering import environment

#: Told to a page that shows something else than what the changes begin from, or whose rows are not the class's.
OUTDATED = "outdated"


@dataclass(frozen=True)
class Page:
    """A page that somebody looks at: `version` is that of the board it shows; `everything`: all misconceptions."""

    course: Course
    href: str
    version: str
    everything: bool


def changes(view: Page, before: Board | None, shown: Board) -> str:
    """From `before` (at first: from what the page shows) to the board that is shown now."""
    if before is None:
        told = [] if view.version == shown.version else [(OUTDATED, "")]
    elif (before.students_shown, before.exercises) != (shown.students_shown, shown.exercises):
        told = [(OUTDATED, "")]
    else:
        told = _parts(view, before, shown)
    # The id comes last: a browser that lost some of this begins again from before it.
    return "".join(sse(name, text) for name, text in told) + f"id: {shown.version}\n" + sse("version", shown.version)


def _parts(view: Page, before: Board, shown: Board) -> list[tuple[str, str]]:
    macros: Any = environment().get_template("classes/board_parts.html").module
    told = []
    for cell in shown.changed_since(before):
        html = root.written(str(cell_html(view.href, cell, shown.titles)))
        told.append(("cell", json.dumps({"key": key_of(cell), "html": html})))
    if before.counts != shown.counts:
        told.append(("counts", root.written(str(macros.counts(CountsView(**vars(shown.counts)))))))
    if before.misconceptions != shown.misconceptions:
        rows = mistake_rows(ShownBoard.of(view.course, view.href, shown), everything=view.everything)
        told.append(("misconceptions", root.written(str(macros.mistakes(rows)))))
    return told
