"""What was changed, in French: names of values, and the values, for pages and files."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from datetime import datetime
from typing import Any

NOTHING = "rien"
FIELDS: Mapping[str, str] = {
    "title": "titre",
    "mode": "mode",
    "opens_at": "ouvre le",
    "due_at": "à rendre le",
    "closes_at": "ferme le",
    "late": "retard",
    "late_per_day": "points retirés par jour de retard",
    "counts": "essai qui compte",
    "weight": "coefficient",
    "hints": "indices",
    "diagnosis": "diagnostic",
    "solution": "corrigé",
    "duration_minutes": "durée (minutes)",
    "released_at": "rendu le",
    "exercises": "exercices",
    "time_factor": "facteur de temps",
    "excused": "dispense",
    "label": "groupe",
    "points": "points",
    "role": "rôle",
    "name": "nom",
    "explanation": "explication",
    "question": "question",
}
SHOWN = {"usual": "comme d’habitude", "after_due": "après la date de rendu", "after_close": "après la fermeture",
         "never": "jamais"}  # fmt: skip
VALUES: Mapping[str, Mapping[str, str]] = {
    "mode": {"practice": "entraînement", "test": "contrôle"},
    "late": {"refuse": "refusé", "accept": "accepté, signalé", "penalty": "accepté, avec des points en moins"},
    "counts": {"best": "le meilleur", "last": "le dernier", "best_before_due": "le meilleur avant la date de rendu"},
    "hints": SHOWN,
    "diagnosis": SHOWN,
    "solution": SHOWN,
    "role": {"student": "élève", "assistant": "assistant", "teacher": "enseignant"},
}
FormatDate = Callable[[datetime], str]


@dataclass(frozen=True)
class ValueChange:
    """One value, before and after: `NOTHING` for none, empty where it is not said."""

    name: str
    before: str
    after: str

    def __str__(self) -> str:
        both = " → ".join(filter(None, (self.before, self.after)))
        return f"{self.name} : {both}"


def describe_changes(before: Mapping[str, Any], after: Mapping[str, Any], when: FormatDate) -> tuple[ValueChange, ...]:
    """In the order in which they are kept."""
    return tuple(
        ValueChange(FIELDS.get(name, name), _told(name, before, when), _told(name, after, when))
        for name in {**before, **after}
    )


def _told(name: str, values: Mapping[str, Any], when: FormatDate) -> str:
    return format_value(name, values[name], when) if name in values else ""


def format_value(name: str, one: Any, when: FormatDate) -> str:
    """A plain value, as `audit.service.note` keeps it."""
    if one is None:
        return NOTHING
    if isinstance(one, bool):
        return "oui" if one else "non"
    if isinstance(one, int | float):
        return f"{round(one, 2):.12g}".replace(".", ",")
    if isinstance(one, Mapping):
        return ", ".join(f"{key} ({format_value('', each, when)})" for key, each in one.items()) or NOTHING
    if isinstance(one, list | tuple):
        return ", ".join(format_value("", each, when) for each in one) or NOTHING
    known = VALUES.get(name, {}).get(str(one))
    return known or (_date(str(one), when) if name.endswith("_at") else str(one))


def _date(text: str, when: FormatDate) -> str:
    try:
        return when(datetime.fromisoformat(text))
    except ValueError:
        return text
