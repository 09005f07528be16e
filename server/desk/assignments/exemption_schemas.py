"""What the templates of exemptions, and of the reasons of dates, receive."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from server.desk.assignments.late_line import LateLine
from server.desk.assignments.schemas import FormattedDate
from server.desk.schemas import ClassHead


@dataclass(frozen=True)
class ExemptionRow:
    """`who` is a student or a group; `effects` by the field's name; `revoked` is empty while it holds."""

    id: str
    who: str
    is_group: bool
    why_href: str
    effects: tuple[tuple[str, str], ...]
    reason: str
    by: str
    made: FormattedDate
    revoked: FormattedDate


@dataclass(frozen=True)
class ExemptionValues:
    """What the fields of the form hold, as text."""

    students: tuple[str, ...] = ()
    group: str = ""
    opens: str = ""
    due: str = ""
    closes: str = ""
    factor: str = ""
    excused: str = ""
    reason: str = ""
    replace: bool = True


@dataclass(frozen=True)
class ExemptionsPage:
    """`order` is how the list is sorted: by `eleve` or by `date`."""

    head: ClassHead
    title: str
    href: str
    version: str
    rows: tuple[ExemptionRow, ...]
    order: str
    students: tuple[tuple[str, str], ...]
    groups: tuple[str, ...]
    values: ExemptionValues
    problems: Mapping[str, str]
    may_keep: bool
    zone: str
    own: tuple[tuple[str, str], ...]
    warnings: Sequence[str]


@dataclass(frozen=True)
class ExplanationStep:
    """What somebody has said of a field; `holds` is what is in force. `reason` is empty for a student."""

    who: str
    value: str
    reason: str
    holds: bool


@dataclass(frozen=True)
class ExplainedField:
    name: str
    value: str
    steps: tuple[ExplanationStep, ...]


@dataclass(frozen=True)
class RulesExplanationPage:
    """The rules in force for one student, and where each comes from. `people` are whom one may choose.

    `sitting`: of a test, when they began it, and its end.
    """

    head: ClassHead
    title: str
    href: str
    student: str
    name: str
    fields: tuple[ExplainedField, ...]
    late: str
    line: LateLine
    people: tuple[tuple[str, str], ...]
    for_staff: bool
    is_concerned: bool = True
    sitting: str = ""
