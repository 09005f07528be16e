"""From the board of a class to its page."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any
from urllib.parse import urlencode
from uuid import UUID

from markupsafe import Markup

from server.base import school_time
from server.board import insights, service
from server.board.schemas import Board, BoardStudent, MisconceptionStats, ProgressCell, ProgressState
from server.board.stuck import RULE
from server.classes import repository as classes
from server.classes.folding import normalise_name
from server.database import utc_now
from server.desk.board.links import BoardLinks, misconception_href, work_href
from server.desk.board.schemas import (
    BoardBody,
    BoardCell,
    BoardLink,
    BoardPage,
    BoardRow,
    MisconceptionRow,
    SortLink,
)
from server.desk.board.side_panel import number_text, side_panel
from server.desk.views import class_head, class_href, count_students_by_label, join_code_view
from server.marks.states import STATE_WORDS, MarkState
from server.rights.models import Right
from server.rights.service import ClassAccess
from server.web.fragments import FRAGMENTS
from server.web.rendering import jinja_environment
from server.web.views import Reader
from server.web.words import count_with_noun, format_iso_time, format_mark, format_short_time

STUDENTS_PER_PAGE = 60
FIRST_MISCONCEPTIONS = 12
#: Up to so many, a list needs no search.
FEW_STUDENTS = 12
BY_NAME, BY_SUCCESS, BY_TROUBLE = "nom", "reussis", "bloques"
SIGNS = {
    ProgressState.none: "",
    ProgressState.trying: "…",
    ProgressState.stuck: "!",
    ProgressState.solved: "✓",
}
WORDS = {
    ProgressState.none: "pas commencé",
    ProgressState.trying: "essayé, pas encore réussi",
    ProgressState.stuck: "bloqué en ce moment",
    ProgressState.solved: "réussi",
}
NOT_CONCERNED_SIGN = "–"
#: The order of a column: who needs help comes first.
TROUBLE_ORDER = {ProgressState.stuck: 0, ProgressState.trying: 1, ProgressState.none: 2, ProgressState.solved: 3}


@dataclass(frozen=True)
class BoardQuery:
    """The query of the address: a group, a sort key ("-" before it: backwards), a page, all misconceptions or some, and
    what names contain."""

    group: str = ""
    sort: str = BY_NAME
    page: int = 1
    everything: bool = False
    search: str = ""

    @property
    def backwards(self) -> bool:
        return self.sort.startswith("-")

    def matches(self, student: BoardStudent) -> bool:
        """Whether a student is in the group, and has all words of the search; accents and case aside."""
        if self.group and self.group not in student.groups:
            return False
        name = normalise_name(student.name) if self.search else ""
        return all(word in name for word in normalise_name(self.search).split())

    @property
    def column(self) -> str:
        return self.sort.removeprefix("-")


def board_page(reader: Reader, access: ClassAccess, query: BoardQuery, base: str) -> BoardPage:
    """Build the page, rendering only the fragments that are not cached. `base` is the address of the service."""
    db, course, school_class = reader.db, reader.course, access.school_class
    inputs = service.load_board_inputs(db, course, school_class, utc_now())
    progress = inputs.progress
    unnamed_groups = tuple(service.load_unnamed_behaviour_groups(db, progress))
    may_regrade = access.has(Right.regrade)
    links = BoardLinks(course, class_href(school_class), progress.students)

    def render_side_panel() -> str:
        panel = side_panel(links, service.build_board_statistics(progress, unnamed_groups), may_regrade=may_regrade)
        return str(_macros("board_body").side_panel(panel))

    side_panel_key = (
        *("board side panel", progress.version, unnamed_groups, insights.activity_slot_start(progress.now)),
        *(may_regrade, school_time.time_zone().key),
    )
    return BoardPage(
        head=class_head(course, access, "/tableau"),
        has_students=bool(progress.students),
        rule=RULE,
        waiting=classes.count_students(db, [school_class.id])[school_class.id][1],
        code=join_code_view(school_class, base) if not progress.students and access.has(Right.see_code) else None,
        version=inputs.version_text,
        stream=f"{links.href}/evenements{'?erreurs=toutes' if query.everything else ''}",
        again=_board_href(links, query),
        generated=format_iso_time(progress.now),
        generated_text=format_short_time(progress.now),
        counts=FRAGMENTS.get_or_render(("board counts", inputs.version), lambda: render_counts(inputs.board)),
        body=FRAGMENTS.get_or_render(
            ("board body", inputs.version, query),
            lambda: str(_macros("board_body").body(_board_body(inputs.board, links, query))),
        ),
        side_panel=FRAGMENTS.get_or_render(side_panel_key, render_side_panel),
    )


def _macros(template: str) -> Any:
    return jinja_environment().get_template(f"classes/{template}.html").module


def render_counts(board: Board) -> str:
    return str(_macros("board_parts").counts(board.counts))


def render_cell(class_href: str, board: Board, cell: ProgressCell) -> str:
    return str(_macros("board_parts").cell(board_cell(class_href, board, cell)))


def render_misconceptions(links: BoardLinks, board: Board, *, everything: bool) -> str:
    return str(_macros("board_parts").misconceptions(_misconception_rows(links, board, everything=everything)))


def _board_body(board: Board, links: BoardLinks, query: BoardQuery) -> BoardBody:
    chosen = list(filter(query.matches, board.students))
    ordered = _sort_students(board, chosen, query)
    first = (query.page - 1) * STUDENTS_PER_PAGE
    page_count = -(-len(ordered) // STUDENTS_PER_PAGE)
    return BoardBody(
        misconceptions=_misconception_rows(links, board, everything=query.everything),
        more_misconceptions=_more_misconceptions(links, board, query),
        names=_sort_link(links, query, BY_NAME, "Élève"),
        solved=_sort_link(links, query, BY_SUCCESS, "Réussis"),
        columns=tuple(_sort_link(links, query, name, links.title(name)) for name in board.exercises),
        sorts=tuple(
            BoardLink(label, _board_href(links, query, sort=sort, page=1), query.sort == sort)
            for sort, label in ((BY_NAME, "par nom"), (BY_TROUBLE, "bloqués d’abord"), (BY_SUCCESS, "par réussites"))
        ),
        groups=_group_links(links, query),
        rows=tuple(_render_row(links, board, student) for student in ordered[first : first + STUDENTS_PER_PAGE]),
        student_count=len(ordered),
        pages=tuple(
            BoardLink(str(number), _board_href(links, query, page=number), number == query.page)
            for number in range(1, page_count + 1)
        ),
        search=query.search,
        search_href=f"{links.href}/tableau#avancement",
        search_fields=tuple(_query_fields(query, q="", page=1).items()),
        unsearched=_board_href(links, query, q="", page=1),
        is_long=len(board.students) > FEW_STUDENTS,
        leaves_out=not all(cell.is_concerned for row in board.rows.values() for cell in row),
    )


def _board_href(links: BoardLinks, query: BoardQuery, **changes: str | int) -> str:
    """Return the address of the board with this query, but for `changes`."""
    fields, address = _query_fields(query, **changes), f"{links.href}/tableau"
    return f"{address}?{urlencode(fields)}#avancement" if fields else f"{address}#avancement"


def _query_fields(query: BoardQuery, **changes: str | int) -> dict[str, str | int]:
    """Return the fields of the address that are not the usual ones, but for `changes`."""
    fields: dict[str, str | int] = {"groupe": query.group, "tri": query.sort, "page": query.page, "q": query.search}
    fields |= {{"sort": "tri", "group": "groupe"}.get(name, name): value for name, value in changes.items()}
    defaults = {"groupe": "", "tri": BY_NAME, "page": 1, "q": ""}
    fields = {name: value for name, value in fields.items() if value != defaults[name]}
    return fields | ({"erreurs": "toutes"} if query.everything else {})


def _sort_link(links: BoardLinks, query: BoardQuery, column: str, label: str) -> SortLink:
    """Return a link that sorts by a column, the other way round where it sorts already."""
    here = query.column == column
    order = "none" if not here else "descending" if query.backwards else "ascending"
    wanted = f"-{column}" if order == "ascending" else column
    return SortLink(label, _board_href(links, query, sort=wanted, page=1), order)


def _sort_students(board: Board, students: Sequence[BoardStudent], query: BoardQuery) -> Sequence[BoardStudent]:
    rows = board.rows
    if query.column == BY_SUCCESS:
        ordered = sorted(students, key=lambda student: -_count_solved(rows[student.id]))
    elif query.column == BY_TROUBLE:
        ordered = sorted(students, key=lambda student: -_count_stuck(rows[student.id]))
    elif query.column in board.exercises:
        place = board.exercises.index(query.column)
        ordered = sorted(students, key=lambda student: _trouble_sort_key(rows[student.id][place]))
    else:
        ordered = list(students)
    return ordered[::-1] if query.backwards else ordered


def _trouble_sort_key(cell: ProgressCell) -> tuple[int, float]:
    return TROUBLE_ORDER[cell.state], cell.points or 0.0


def _count_solved(cells: Sequence[ProgressCell]) -> int:
    return sum(cell.state is ProgressState.solved for cell in cells)


def _count_stuck(cells: Sequence[ProgressCell]) -> int:
    return sum(cell.state is ProgressState.stuck for cell in cells)


def _group_links(links: BoardLinks, query: BoardQuery) -> tuple[BoardLink, ...]:
    sizes = count_students_by_label(student.groups for student in links.students)
    if not sizes:
        return ()
    everyone = BoardLink("Tous", _board_href(links, query, group="", page=1), not query.group)
    return everyone, *(
        BoardLink(f"{label} ({size})", _board_href(links, query, group=label, page=1), query.group == label)
        for label, size in sizes.items()
    )


def _render_row(links: BoardLinks, board: Board, student: BoardStudent) -> Markup:
    """Return the row of a student, rendered only where it is not cached: most are as they were before a verdict."""
    key = ("board row", links.course, links.href, student.id, student.name, board.rows[student.id])
    return FRAGMENTS.get_or_render(key, lambda: str(_macros("board_parts").row(_board_row(links.href, board, student))))


def _board_row(class_href: str, board: Board, student: BoardStudent) -> BoardRow:
    cells = board.rows[student.id]
    return BoardRow(
        key=str(student.id),
        name=student.name,
        href=f"{class_href}/eleves/{student.id}",
        solved=_count_solved(cells),
        cells=tuple(board_cell(class_href, board, cell) for cell in cells),
    )


def board_cell(class_href: str, board: Board, cell: ProgressCell) -> BoardCell:
    tried, misconception = cell.attempts > 0, cell.misconception
    by = f"rendu par {cell.partner}" if cell.partner else ""
    is_left_out = not (tried or by or cell.is_concerned)
    label = WORDS[cell.state] + (f", {count_with_noun(cell.attempts, 'essai')}" if tried else f", {by}" if by else "")
    if misconception is not None and cell.state is not ProgressState.solved:
        label += f" : {board.misconception_titles.get((cell.exercise, misconception), misconception)}"
    return BoardCell(
        key=cell_key(cell.student, cell.exercise),
        kind=cell.state.value,
        sign=NOT_CONCERNED_SIGN if is_left_out else SIGNS[cell.state],
        text="" if cell.points is None else format_mark(cell.points),
        label=STATE_WORDS[MarkState.not_concerned] if is_left_out else label,
        href=work_href(class_href, cell.student, cell.exercise) if tried or by else "",
        by=by,
    )


def cell_key(student: UUID, exercise: str) -> str:
    return f"{student} {exercise}"


def _misconception_rows(links: BoardLinks, board: Board, *, everything: bool) -> tuple[MisconceptionRow, ...]:
    stats = board.misconceptions if everything else board.misconceptions[:FIRST_MISCONCEPTIONS]
    return tuple(misconception_row(links, stat) for stat in stats)


def misconception_row(links: BoardLinks, stats: MisconceptionStats) -> MisconceptionRow:
    return MisconceptionRow(
        key=f"{stats.exercise} {stats.id}",
        title=stats.title,
        href=misconception_href(links.href, stats.exercise, stats.id),
        exercise=links.title(stats.exercise),
        exercise_href=links.exercise_href(stats.exercise),
        now=stats.now,
        share=round(100 * stats.now / max(1, len(links.students)), 1),
        ever=stats.ever,
        overcome=stats.overcome,
        attempts=number_text(stats.median_attempts),
    )


def _more_misconceptions(links: BoardLinks, board: Board, query: BoardQuery) -> BoardLink | None:
    total = len(board.misconceptions)
    if total <= FIRST_MISCONCEPTIONS:
        return None
    if query.everything:
        return BoardLink("Ne montrer que les premières", f"{links.href}/tableau#erreurs", False)
    return BoardLink(f"Montrer les {total} erreurs reconnues", f"{links.href}/tableau?erreurs=toutes#erreurs", False)
