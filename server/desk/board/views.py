"""From the board of a class to what its page shows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any
from urllib.parse import urlencode

from markupsafe import Markup

from server.board import service
from server.board.schemas import BoardStudent, MisconceptionStats, ProgressCell, ProgressState
from server.board.states import RULE
from server.classes import repository as classes
from server.database import utc_now
from server.desk.board import kept
from server.desk.board.schemas import BoardPage, CellView, Choice, CountsView, MistakeRow, RowView, Sorter, WorkView
from server.desk.board.shown import Shown, ShownBoard, mistake_href, work_href
from server.desk.views import code_view, group_counts, head, href_of
from server.rights.models import Right
from server.rights.service import Place
from server.web.rendering import environment
from server.web.views import Reader
from server.web.words import mark, moment, moment_text, plural, points

STUDENTS_A_PAGE = 60
MISTAKES_AT_FIRST = 12
MOST_CELLS = 16_384  # kept as they were drawn
BY_NAME, BY_SUCCESS, BY_TROUBLE = "nom", "reussis", "bloques"
SIGNS = {ProgressState.none: "·", ProgressState.trying: "…", ProgressState.stuck: "!", ProgressState.solved: "✓"}
WORDS = {
    ProgressState.none: "pas commencé",
    ProgressState.trying: "essayé, pas encore réussi",
    ProgressState.stuck: "bloqué en ce moment",
    ProgressState.solved: "réussi",
}
#: What comes first in a column: who needs help.
TROUBLE = {ProgressState.stuck: 0, ProgressState.trying: 1, ProgressState.none: 2, ProgressState.solved: 3}


@dataclass(frozen=True)
class BoardQuery:
    """What one wants to see of a board: of which group, in which order, which page; all misconceptions or some."""

    group: str = ""
    sort: str = BY_NAME
    page: int = 1
    everything: bool = False

    @property
    def backwards(self) -> bool:
        return self.sort.startswith("-")

    @property
    def column(self) -> str:
        return self.sort.removeprefix("-")


def board_page(reader: Reader, place: Place, asked: BoardQuery, base: str) -> BoardPage:
    """`base` is the address of the service."""
    db, course, school_class = reader.db, reader.course, place.school_class
    board, insights = service.load_dashboard(db, course, school_class, utc_now())
    shown = ShownBoard.of(course, href_of(school_class), board)
    query = "?erreurs=toutes" if asked.everything else ""
    return BoardPage(
        head=head(course, place, ""),
        counts=CountsView(**vars(board.counts)),
        rule=RULE,
        waiting=classes.counts(db, [school_class.id])[school_class.id][1],
        code=code_view(school_class, base) if not board.students and place.may(Right.see_code) else None,
        version=board.version,
        stream=f"{shown.href}/evenements{query}",
        again=_href(shown, asked),
        generated=moment(board.generated_at),
        generated_text=moment_text(board.generated_at),
        work=kept.work(shown, asked, lambda: _work(shown, asked)),
        beside=kept.beside(shown, insights, may_regrade=place.may(Right.regrade)),
    )


def _work(shown: ShownBoard, asked: BoardQuery) -> WorkView:
    board = shown.board
    chosen = [one for one in board.students if not asked.group or asked.group in one.groups]
    ordered = _ordered(shown, chosen, asked)
    first = (asked.page - 1) * STUDENTS_A_PAGE
    return WorkView(
        mistakes=mistake_rows(shown, everything=asked.everything),
        more_mistakes=_more(shown, asked),
        names=_sorter(shown, asked, BY_NAME, "Élève"),
        solved=_sorter(shown, asked, BY_SUCCESS, "Réussis"),
        columns=tuple(_sorter(shown, asked, name, shown.title(name)) for name in board.exercises),
        sorts=tuple(
            Choice(label, _href(shown, asked, sort=sort, page=1), asked.sort == sort)
            for sort, label in ((BY_NAME, "par nom"), (BY_TROUBLE, "bloqués d’abord"), (BY_SUCCESS, "par réussites"))
        ),
        groups=_groups(shown, asked),
        rows=tuple(_row(shown, one) for one in ordered[first : first + STUDENTS_A_PAGE]),
        found=len(ordered),
        pages=tuple(
            Choice(str(number), _href(shown, asked, page=number), number == asked.page)
            for number in range(1, -(-len(ordered) // STUDENTS_A_PAGE) + 1)
        ),
    )


def _href(shown: Shown, asked: BoardQuery, **changed: str | int) -> str:
    """The address of the board as it is asked for, but for what is changed."""
    wanted = {"groupe": asked.group, "tri": asked.sort, "page": asked.page}
    wanted |= {{"sort": "tri", "group": "groupe"}.get(name, name): value for name, value in changed.items()}
    usual = {"groupe": "", "tri": BY_NAME, "page": 1}
    query = {name: value for name, value in wanted.items() if value != usual[name]}
    query |= {"erreurs": "toutes"} if asked.everything else {}
    return f"{shown.href}?{urlencode(query)}#avancement" if query else f"{shown.href}#avancement"


def _sorter(shown: Shown, asked: BoardQuery, column: str, label: str) -> Sorter:
    """Leads to the other order where the column sorts already."""
    here = asked.column == column
    order = "none" if not here else "descending" if asked.backwards else "ascending"
    wanted = f"-{column}" if order == "ascending" else column
    return Sorter(label, _href(shown, asked, sort=wanted, page=1), order)


def _ordered(shown: ShownBoard, students: Sequence[BoardStudent], asked: BoardQuery) -> Sequence[BoardStudent]:
    cells, rows = shown.board.cells, shown.board.rows
    if asked.column == BY_SUCCESS:
        ordered = sorted(students, key=lambda one: -_solved(rows[one.id]))
    elif asked.column == BY_TROUBLE:
        ordered = sorted(students, key=lambda one: -sum(cell.state is ProgressState.stuck for cell in rows[one.id]))
    elif asked.column in shown.board.exercises:
        ordered = sorted(students, key=lambda one: _trouble(cells[one.id, asked.column]))
    else:
        ordered = list(students)
    return ordered[::-1] if asked.backwards else ordered


def _trouble(cell: ProgressCell) -> tuple[int, float]:
    return TROUBLE[cell.state], cell.points or 0.0


def _solved(cells: Sequence[ProgressCell]) -> int:
    return sum(cell.state is ProgressState.solved for cell in cells)


def _groups(shown: ShownBoard, asked: BoardQuery) -> tuple[Choice, ...]:
    sizes = group_counts(one.groups for one in shown.board.students)
    if not sizes:
        return ()
    every = Choice("Tous", _href(shown, asked, group="", page=1), not asked.group)
    return every, *(
        Choice(f"{label} ({size})", _href(shown, asked, group=label, page=1), asked.group == label)
        for label, size in sizes.items()
    )


def _row(shown: ShownBoard, student: BoardStudent) -> RowView:
    cells = shown.board.rows[student.id]
    return RowView(
        key=str(student.id),
        name=student.name,
        href=f"{shown.href}/eleves/{student.id}",
        groups=student.groups,
        solved=_solved(cells),
        cells=Markup("".join(cell_html(shown.href, cell, shown.board.titles) for cell in cells)),
    )


def cell_html(class_href: str, cell: ProgressCell, titles: Mapping[tuple[str, str], str]) -> Markup:
    """The cell as the page and its stream show it; `titles`: those of misconceptions, by exercise and id."""
    name = cell.misconception
    return _drawn(class_href, cell, "" if name is None else titles.get((cell.exercise, name), name))


@lru_cache(maxsize=MOST_CELLS)
def _drawn(class_href: str, cell: ProgressCell, title: str) -> Markup:
    """Most cells of a board are what they were a moment ago, and drawing all of them is most of what it costs."""
    macros: Any = environment().get_template("classes/board_parts.html").module
    return Markup(macros.cell(cell_view(class_href, cell, title)))


def cell_view(class_href: str, cell: ProgressCell, title: str) -> CellView:
    """`title` is that of its misconception, if it has one."""
    tried = cell.attempts > 0
    label = WORDS[cell.state] + (f", {plural(cell.attempts, 'essai')}" if tried else "")
    if cell.misconception is not None and cell.state is not ProgressState.solved:
        label += f" : {title}"
    return CellView(
        key=key_of(cell),
        kind=cell.state.value,
        sign=SIGNS[cell.state],
        text="" if cell.points is None else mark(cell.points),
        label=label,
        href=work_href(class_href, cell.student, cell.exercise) if tried else "",
    )


def key_of(cell: ProgressCell) -> str:
    return f"{cell.student} {cell.exercise}"


def mistake_rows(shown: ShownBoard, *, everything: bool) -> tuple[MistakeRow, ...]:
    rows = shown.board.misconceptions
    return tuple(mistake_row(shown, one) for one in (rows if everything else rows[:MISTAKES_AT_FIRST]))


def mistake_row(shown: Shown, one: MisconceptionStats) -> MistakeRow:
    return MistakeRow(
        key=f"{one.exercise} {one.id}",
        title=one.title,
        href=mistake_href(shown.href, one.exercise, one.id),
        exercise=shown.title(one.exercise),
        exercise_href=shown.exercise_href(one.exercise),
        now=one.now,
        share=round(100 * one.now / max(1, len(shown.students)), 1),
        ever=one.ever,
        overcome=one.overcome,
        attempts="—" if one.median_attempts is None else points(one.median_attempts),
    )


def _more(shown: ShownBoard, asked: BoardQuery) -> Choice | None:
    total = len(shown.board.misconceptions)
    if total <= MISTAKES_AT_FIRST:
        return None
    if asked.everything:
        return Choice("Ne montrer que les premières", f"{shown.href}#erreurs", False)
    return Choice(f"Montrer les {total} erreurs reconnues", f"{shown.href}?erreurs=toutes#erreurs", False)
