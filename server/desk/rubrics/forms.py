"""The forms of rubrics and of copies: from what is typed to rubrics and marks, and back."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

from starlette.datastructures import FormData

from server.assignments.models import Assignment
from server.base.errors import Invalid, InvalidFields
from server.marks import rubrics_repository
from server.marks.means import format_number
from server.marks.models import ManualColumn, Rubric
from server.marks.rubric_items import (
    MAX_ITEMS,
    OVERALL,
    RubricInput,
    RubricItem,
    RubricScores,
    format_levels,
    parse_rubric_item,
    parse_rubric_scores,
)

EMPTY_ROWS = 3
DEFAULT_TITLE = "{title} : à la main"


@dataclass(frozen=True)
class ItemRow:
    """An item as it is typed; `id` is empty for a new one."""

    id: str = ""
    title: str = ""
    points: str = ""
    words: str = ""
    problem: str = ""

    @property
    def is_empty(self) -> bool:
        return not (self.title.strip() or self.points.strip() or self.words.strip())


@dataclass(frozen=True)
class RubricForm:
    """The fields of a rubric as they are typed, and by field what is wrong."""

    title: str
    weight: str = "1"
    anonymous: bool = False
    rows: tuple[ItemRow, ...] = ()
    problems: Mapping[str, str] = field(default_factory=dict)

    @property
    def texts(self) -> Mapping[str, str]:
        """The fields by their labels, to compare two versions."""
        items = [f"{row.title.strip()} / {row.points.strip()}\n{row.words.strip()}" for row in self.rows]
        return {
            "Titre": self.title.strip(),
            "Coefficient": self.weight.strip(),
            "Sans les noms": "oui" if self.anonymous else "non",
            "Critères": "\n".join(items),
        }


def stored_form(assignment: Assignment, row: tuple[Rubric, ManualColumn] | None) -> RubricForm:
    if row is None:
        return RubricForm(DEFAULT_TITLE.format(title=assignment.title)[:100])
    rubric, column = row
    rows = tuple(
        ItemRow(item.id, item.title, format_number(item.points), format_levels(item.levels))
        for item in rubrics_repository.read_rubric_items(rubric)
    )
    return RubricForm(column.title, format_number(column.weight), rubric.anonymous, rows)


def read_form(fields: FormData) -> RubricForm:
    """Read the form as it is typed, without the rows that are empty."""
    rows = (
        ItemRow(*(str(fields.get(f"c-{number}-{name}", "")) for name in ("id", "titre", "points", "mots")))
        for number in range(MAX_ITEMS + EMPTY_ROWS)
    )
    title, weight = str(fields.get("titre", "")), str(fields.get("coefficient", "1"))
    return RubricForm(title, weight, "anonyme" in fields, tuple(row for row in rows if not row.is_empty))


def parse_form(form: RubricForm) -> tuple[RubricInput | None, RubricForm]:
    """Return the rubric of a form, None where a row or the weight is wrong, and the form with what is wrong."""
    items, rows, problems = [], [], dict(form.problems)
    for row in form.rows:
        try:
            items.append(parse_rubric_item(row.id, row.title, row.points, row.words))
            rows.append(row)
        except Invalid as refused:
            rows.append(replace(row, problem=refused.detail))
    try:
        weight = float(form.weight.strip().replace(",", "."))
    except ValueError:
        weight = -1.0
    checked = replace(form, rows=tuple(rows), problems=problems)
    if len(items) < len(rows):
        return None, checked
    return RubricInput(form.title, weight, form.anonymous, tuple(items)), checked


@dataclass(frozen=True)
class TypedCopy:
    """What is typed for a copy, by item, and what is wrong with it (the whole under an empty name)."""

    points: Mapping[str, str]
    remarks: Mapping[str, str]
    problems: Mapping[str, str] = field(default_factory=dict)


def read_copy(fields: FormData, items: Sequence[RubricItem]) -> TypedCopy:
    """Read the points, typed or picked by their words, and the remarks of a copy."""
    points = {}
    for item in items:
        typed = str(fields.get(f"p-{item.id}", "")).strip()
        points[item.id] = typed or str(fields.get(f"n-{item.id}", ""))
    remarks = {item.id: str(fields.get(f"r-{item.id}", "")) for item in items}
    return TypedCopy(points, remarks | {OVERALL: str(fields.get("remarque", ""))})


def parse_copy(items: Sequence[RubricItem], typed: TypedCopy) -> RubricScores:
    """Return the marks of a copy. Raise InvalidFields."""
    return parse_rubric_scores(items, typed.points, typed.remarks)


def with_refusal(typed: TypedCopy, refused: Invalid) -> TypedCopy:
    problems = refused.problems if isinstance(refused, InvalidFields) else {OVERALL: refused.detail}
    return replace(typed, problems=problems)
