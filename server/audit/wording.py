"""French names of changed fields and values, for pages and files."""

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
    "removed_at": "supprimé le",
    "past_rules": "règles d’avant",
    "extends": "prolonge seulement",
    "handed_in_at": "copie rendue le",
    "exercises": "exercices",
    "time_factor": "facteur de temps",
    "excused": "dispense",
    "label": "groupe",
    "team": "binôme ou équipe",
    "team_size": "élèves par copie",
    "teams_by_students": "équipes formées par les élèves",
    "groups": "groupes",
    "points": "points",
    "state": "état",
    "not_handed_in": "non rendu",
    "late_refused": "refusé (retard)",
    "absent": "absent",
    "unanswered": "exercice sans réponse",
    "out_of": "sur",
    "taken_on": "date",
    "bonus": "bonus",
    "published_at": "publiée le",
    "position": "place",
    "role": "rôle",
    "name": "nom",
    "explanation": "explication",
    "question": "question",
    "attempts": "essais",
    "marks": "notes saisies",
    "accounts": "comptes",
    "accesses": "accès",
    "corrected": "lignes corrigées",
    "rows": "lignes",
    "made_at": "faite le",
}
SHOWN = {"usual": "comme d’habitude", "after_due": "après la date de rendu", "after_close": "après la fermeture",
         "never": "jamais"}  # fmt: skip
COUNTED = {"ignore": "ne compte pas", "zero": "compte 0"}
VALUES: Mapping[str, Mapping[str, str]] = {
    "state": {"absent": "absent", "excused": "dispensé", "zero": "0", "not_handed_in": "non rendu"},
    **dict.fromkeys(("not_handed_in", "late_refused", "absent", "unanswered"), COUNTED),
    "mode": {"practice": "entraînement", "test": "contrôle"},
    "late": {"refuse": "refusé", "accept": "accepté, signalé", "penalty": "accepté, avec des points en moins"},
    "counts": {"best": "le meilleur", "last": "le dernier", "best_before_due": "le meilleur avant la date de rendu"},
    "hints": SHOWN,
    "diagnosis": SHOWN,
    "solution": SHOWN,
    "role": {"student": "élève", "assistant": "assistant", "teacher": "enseignant", "administrator": "administrateur"},
}
FormatDate = Callable[[datetime], str]


@dataclass(frozen=True)
class ValueChange:
    """A value before and after, in French: `NOTHING` for None, empty where it is absent."""

    name: str
    before: str
    after: str

    def __str__(self) -> str:
        both = " → ".join(filter(None, (self.before, self.after)))
        return f"{self.name} : {both}"


def describe_changes(before: Mapping[str, Any], after: Mapping[str, Any], when: FormatDate) -> tuple[ValueChange, ...]:
    """Describe the changed values in the order in which they are stored."""
    return tuple(
        ValueChange(FIELDS.get(name, name), _describe_value(name, before, when), _describe_value(name, after, when))
        for name in {**before, **after}
    )


def _describe_value(name: str, values: Mapping[str, Any], when: FormatDate) -> str:
    return format_audited_value(name, values[name], when) if name in values else ""


def format_audited_value(name: str, plain: Any, when: FormatDate) -> str:
    """Format a plain value, as `audit.service.record_event` stores it."""
    if plain is None:
        return NOTHING
    if isinstance(plain, bool):
        return "oui" if plain else "non"
    if isinstance(plain, int | float):
        return f"{round(plain, 2):.12g}".replace(".", ",")
    if isinstance(plain, Mapping):
        return ", ".join(f"{key} ({format_audited_value('', item, when)})" for key, item in plain.items()) or NOTHING
    if isinstance(plain, list | tuple):
        return ", ".join(format_audited_value("", item, when) for item in plain) or NOTHING
    label = VALUES.get(name, {}).get(str(plain))
    return label or (_format_date(str(plain), when) if name.endswith("_at") else str(plain))


def _format_date(text: str, when: FormatDate) -> str:
    try:
        return when(datetime.fromisoformat(text))
    except ValueError:
        return text
