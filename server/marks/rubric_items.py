"""A rubric as teachers write and use it: its items, the words to pick, the marks of one copy. Pure."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any
from uuid import uuid4

from server.base.errors import Invalid, InvalidFields
from server.marks.means import format_number
from server.marks.models import COLUMN_TITLE_LENGTH
from server.marks.typed import NO_WEIGHT, parse_typed_mark, require_points_on_scale
from server.text.lines import describe_forbidden_character, normalise_line, normalise_lines, require_normalised_line

MAX_ITEMS, MAX_LEVELS = 30, 10
ITEM_LENGTH, LEVEL_LENGTH, REMARK_LENGTH = 120, 300, 2000
MAX_ITEM_POINTS = 100.0
#: The key of the remark on the whole copy.
OVERALL = ""
LEVEL = re.compile(r"\s*(?P<points>[0-9]{1,3}(?:[.,][0-9]{1,2})?)\s*(?:pts?|points?)?\s*[:=–—-]\s*(?P<text>.*\S)\s*")
NO_ITEMS = "Écrivez au moins un critère, avec ses points."
TOO_MANY_ITEMS = f"Un barème a {MAX_ITEMS} critères au plus."
NO_ITEM_TITLE = f"Donnez au critère un titre de 1 à {ITEM_LENGTH} caractères."
NO_ITEM_POINTS = "« {title} » : donnez des points de 0,25 à 100, avec deux décimales au plus."
NO_LEVEL = (
    "« {title} », ligne « {line} » : écrivez les points, deux points, puis les mots, par exemple « 2 : noms clairs »."
)
LEVEL_ABOVE = "« {title} » : « {line} » donne plus de points que le critère, qui en a {most}."
SAME_POINTS = "« {title} » : {points} est donné deux fois ; chaque ligne de mots a ses propres points."
TOO_MANY_LEVELS = f"« {{title}} » : {MAX_LEVELS} lignes de mots au plus."
LONG_REMARK = f"Une remarque compte {REMARK_LENGTH} caractères au plus."
MISSING_POINTS = "Donnez des points à chaque critère pour terminer cette copie. Il manque : {titles}."


@dataclass(frozen=True)
class RubricLevel:
    """Words to pick, and the points that they give."""

    points: float
    text: str


@dataclass(frozen=True)
class RubricItem:
    """A criterion: its marks go from 0 to `points`. `id` stays when it is renamed."""

    id: str
    title: str
    points: float
    levels: tuple[RubricLevel, ...] = ()

    @classmethod
    def from_json(cls, row: Mapping[str, Any]) -> RubricItem:
        return cls(**{**row, "levels": tuple(RubricLevel(**level) for level in row["levels"])})

    def to_json(self) -> dict[str, Any]:
        return asdict(self)


@dataclass(frozen=True)
class RubricInput:
    """The fields of a rubric that a teacher sets. `weight`: that of its column in the mean."""

    title: str
    weight: float
    anonymous: bool
    items: tuple[RubricItem, ...]


@dataclass(frozen=True)
class RubricScores:
    """What a teacher has given for a copy: points and remarks by item, the remark on the whole under `OVERALL`."""

    points: Mapping[str, float] = field(default_factory=dict)
    remarks: Mapping[str, str] = field(default_factory=dict)

    def total_over(self, items: Sequence[RubricItem]) -> float:
        """Return the sum of the points of these items."""
        return round(sum(self.points.get(item.id, 0.0) for item in items), 2)

    def titles_without_points(self, items: Sequence[RubricItem]) -> Sequence[str]:
        """Return the titles of the items without points."""
        return [item.title for item in items if item.id not in self.points]


def sum_item_points(items: Sequence[RubricItem]) -> float:
    return round(sum(item.points for item in items), 2)


def format_levels(levels: Sequence[RubricLevel]) -> str:
    """Return the lines that `parse_levels` reads again."""
    return "\n".join(f"{format_number(level.points)} : {level.text}" for level in levels)


def parse_rubric_item(item_id: str, title: str, points: str, words: str) -> RubricItem:
    """Parse an item as it is typed; without `item_id` it is a new one. Raise Invalid."""
    name = require_normalised_line(title, ITEM_LENGTH, NO_ITEM_TITLE)
    most = parse_typed_mark(points, MAX_ITEM_POINTS).points if points.strip() else None
    if most is None or most < 0.25:
        raise Invalid(NO_ITEM_POINTS.format(title=name))
    lines = [line for line in normalise_lines(words).splitlines() if line]
    if len(lines) > MAX_LEVELS:
        raise Invalid(TOO_MANY_LEVELS.format(title=name))
    levels = tuple(_parse_rubric_level(name, most, line) for line in lines)
    points_of_levels = [level.points for level in levels]
    for level in levels:
        if points_of_levels.count(level.points) > 1:
            raise Invalid(SAME_POINTS.format(title=name, points=format_number(level.points)))
    return RubricItem(item_id or uuid4().hex[:8], name, most, levels)


def _parse_rubric_level(title: str, most: float, line: str) -> RubricLevel:
    short = line[:60]
    written = LEVEL.fullmatch(line)
    if written is None:
        raise Invalid(NO_LEVEL.format(title=title, line=short))
    points = float(written["points"].replace(",", "."))
    if points > most:
        raise Invalid(LEVEL_ABOVE.format(title=title, line=short, most=format_number(most)))
    return RubricLevel(
        points, require_normalised_line(written["text"], LEVEL_LENGTH, NO_LEVEL.format(title=title, line=short))
    )


def validate_rubric(fields: RubricInput) -> RubricInput:
    """Return the input with its title tidied. Raise InvalidFields with every problem at once."""
    problems = {}
    title = normalise_line(fields.title)
    if not 0 < len(title) <= COLUMN_TITLE_LENGTH or describe_forbidden_character(title):
        problems["title"] = f"Donnez à la colonne un titre de 1 à {COLUMN_TITLE_LENGTH} caractères."
    if not 0 <= fields.weight <= 1000:
        problems["weight"] = NO_WEIGHT
    if not fields.items:
        problems["criteria"] = NO_ITEMS
    elif len(fields.items) > MAX_ITEMS:
        problems["criteria"] = TOO_MANY_ITEMS
    if problems:
        raise InvalidFields(problems)
    return RubricInput(title, fields.weight, fields.anonymous, fields.items)


def parse_rubric_scores(
    items: Sequence[RubricItem], points: Mapping[str, str], remarks: Mapping[str, str]
) -> RubricScores:
    """Parse the points and remarks of a copy as they are typed; an empty text gives none. Raise InvalidFields, by item.

    Texts of items that the rubric has not are left out.
    """
    problems: dict[str, str] = {}
    given: dict[str, float] = {}
    for item in items:
        text = points.get(item.id, "").strip()
        try:
            if text:
                given[item.id] = require_points_on_scale(_parse_points(text), item.points, text)
        except Invalid as refused:
            problems[item.id] = refused.detail
    said = {}
    for key in (*(item.id for item in items), OVERALL):
        remark = normalise_lines(remarks.get(key, ""))
        unwritable = describe_forbidden_character(remark)
        if len(remark) > REMARK_LENGTH or unwritable:
            problems.setdefault(key, LONG_REMARK if len(remark) > REMARK_LENGTH else f"Dans la remarque, {unwritable}.")
        elif remark:
            said[key] = remark
    if problems:
        raise InvalidFields(problems)
    return RubricScores(given, said)


def _parse_points(text: str) -> float:
    try:
        return float(text.replace(",", ".")[:20])
    except ValueError:
        raise Invalid(f"« {text[:20]} » n’est pas un nombre de points.") from None
