"""Tell which lines of a list are for which class of a teacher, by its column of classes."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from uuid import UUID

from server.base.errors import Invalid
from server.classes.folding import normalise_name
from server.classes.models import SchoolClass
from server.classes.roster import EVERY_CLASS, ReadingChoice, Roster
from server.classes.roster_line import RosterLine

SKIPPED = (
    "{lines} de « {value} » : aucune de vos classes ne porte ce nom, et rien n’en est importé. Créez cette classe, ou "
    "choisissez quelle valeur est celle-ci."
)
NOT_HERE = (
    "Aucune ligne n’est pour « {name} » : la colonne des classes dit {values}. Choisissez laquelle est cette classe."
)
NO_OWN_CLASS = (
    "La colonne des classes dit {values}, et aucune n’est une de vos classes : toutes les lignes entrent dans celle-ci."
)
OTHER_CLASS = (
    "La colonne des classes dit « {value} », qui est une autre de vos classes : vérifiez que c’est la bonne liste."
)
NO_SUCH_VALUE = "La colonne des classes ne dit nulle part « {value} » : elle dit {values}."
MAX_NAMED_VALUES = 8


@dataclass(frozen=True)
class LinesByClass:
    """The lines of a list by class. `values`: those of its column of classes that are this class, empty for all."""

    here: Sequence[RosterLine]
    elsewhere: Mapping[UUID, tuple[SchoolClass, Sequence[RosterLine]]]
    skipped: Mapping[str, int]
    values: tuple[str, ...]
    warnings: tuple[str, ...]


def split_lines_by_class(
    roster: Roster, school_class: SchoolClass, others: Sequence[SchoolClass], choice: ReadingChoice
) -> LinesByClass:
    """Tell which lines are for which class of the teacher, by the names of the classes.

    A column with one value, or whose values name none of them, says nothing: every line is for this class.
    """
    values = list(roster.class_values)
    by_name: dict[str, list[SchoolClass]] = defaultdict(list)
    for other in others:
        by_name[_fold_class_name(other.name)].append(other)
    named = {
        value: by_name[_fold_class_name(value)][0] for value in values if len(by_name[_fold_class_name(value)]) == 1
    }
    chosen = choice.class_value
    here = [value for value in values if _fold_class_name(value) == _fold_class_name(chosen or school_class.name)]
    if chosen and chosen != EVERY_CLASS and not here:
        raise Invalid(NO_SUCH_VALUE.format(value=chosen[:60], values=_quote_values(values)))
    says_nothing = not chosen and (len(values) < 2 or not (here or named))
    if chosen == EVERY_CLASS or says_nothing:
        return LinesByClass(
            roster.lines, {}, {}, (), _warn_about_class_column(values, named, here) if says_nothing else ()
        )
    lines: dict[str, list[RosterLine]] = defaultdict(list)
    for line in roster.lines:
        lines[line.school_class].append(line)
    staying = [line for line in roster.lines if line.school_class in {"", *here}]
    elsewhere = {
        other.id: (other, lines[value]) for value, other in named.items() if value not in here and not choice.only_here
    }
    skipped = {value: len(lines[value]) for value in values if value not in here and value not in named}
    warnings = [
        SKIPPED.format(value=value, lines=f"{count} ligne{'s' * (count > 1)}") for value, count in skipped.items()
    ]
    if not here:
        warnings.append(NOT_HERE.format(name=school_class.name, values=_quote_values(values)))
    return LinesByClass(staying, elsewhere, skipped, tuple(here), tuple(warnings))


def _warn_about_class_column(
    values: Sequence[str], named: Mapping[str, SchoolClass], here: Sequence[str]
) -> tuple[str, ...]:
    """Say what is strange about a column of classes that says nothing."""
    if len(values) == 1 and named and not here:
        return (OTHER_CLASS.format(value=values[0]),)
    return (NO_OWN_CLASS.format(values=_quote_values(values)),) if len(values) > 1 else ()


def _quote_values(values: Sequence[str]) -> str:
    return ", ".join(f"« {value[:40]} »" for value in values[:MAX_NAMED_VALUES]) + (
        "…" if len(values) > MAX_NAMED_VALUES else ""
    )


def _fold_class_name(name: str) -> str:
    """Return a key equal for « MPSI 1 » and « mpsi1 »."""
    return normalise_name(name).replace(" ", "")
