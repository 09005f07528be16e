"""How an assignment and what differs of it are told in French: pages, forms and exports take their words here."""

from __future__ import annotations

from collections.abc import Mapping
from datetime import datetime
from typing import Any

from server.assignments.models import AttemptSelection, LatePolicy, Mode, Visibility
from server.assignments.rule_sources import Field
from server.assignments.rules import Rules
from server.assignments.stages import AssignmentStage
from server.assignments.team_rules import MAX_TEAM_SIZE
from server.web.words import format_long_time, format_points

MODE_WORDS: Mapping[Mode, str] = {Mode.practice: "entraînement", Mode.test: "contrôle"}
STAGE_WORDS: Mapping[AssignmentStage, tuple[str, str]] = {
    AssignmentStage.upcoming: ("◷", "à venir"),
    AssignmentStage.open: ("▶", "ouvert"),
    AssignmentStage.late: ("!", "en retard accepté"),
    AssignmentStage.closed: ("■", "fermé"),
}
SELECTION_WORDS: Mapping[AttemptSelection, str] = {
    AttemptSelection.best: "le meilleur essai",
    AttemptSelection.last: "le dernier essai",
    AttemptSelection.best_before_due: "le meilleur essai avant la date de remise",
}
VISIBILITY_WORDS: Mapping[Visibility, str] = {
    Visibility.usual: "comme d’habitude",
    Visibility.after_due: "après la date de remise",
    Visibility.after_close: "après la fermeture",
    Visibility.never: "jamais",
}
LATE_POLICY_WORDS: Mapping[LatePolicy, str] = {
    LatePolicy.refuse: "refusé",
    LatePolicy.accept: "accepté, et marqué en retard",
    LatePolicy.penalty: "pénalisé",
}
FIELD_NAMES: Mapping[Field, str] = {
    "opens_at": "Ouverture",
    "due_at": "Date limite",
    "closes_at": "Fermeture",
    "time_factor": "Temps",
    "excused": "Dispense",
}
#: In a test, whoever begins in time has their whole time: the date is that of the beginning.
TEST_FIELD_NAMES: Mapping[Field, str] = {**FIELD_NAMES, "due_at": "À commencer avant"}
EMPTY_VALUES: Mapping[str, str] = {"due_at": "pas de date de remise", "closes_at": "reste ouvert"}


TEAM_SIZE_WORDS: Mapping[str, str] = {
    "1": "chacun seul",
    "2": "en binôme",
    **{str(size): f"en équipe de {size} au plus" for size in range(3, MAX_TEAM_SIZE + 1)},
}


def format_number(value: float) -> str:
    """As a form's field holds it: 1,33."""
    return f"{value:.10g}".replace(".", ",")


def describe_late_policy(late: LatePolicy, per_day: float | None) -> str:
    if late is LatePolicy.penalty and per_day:
        points = f"{format_points(per_day)} {'point' if per_day < 2 else 'points'}"
        return f"pénalisé : {points} sur 20 par jour de retard entamé"
    return LATE_POLICY_WORDS[late]


def field_names(*, is_test: bool) -> Mapping[Field, str]:
    return TEST_FIELD_NAMES if is_test else FIELD_NAMES


def describe_late_rules(rules: Rules) -> str:
    return describe_late_policy(rules.late, rules.late_per_day)


def format_duration(minutes: float) -> str:
    """« 55 min », « 1 h 20 », « 2 j 3 h »."""
    whole = round(minutes)
    hours, left = divmod(whole, 60)
    if hours >= 48:
        days, hours = divmod(hours, 24)
        return f"{days} j {hours} h" if hours else f"{days} j"
    return (f"{hours} h {left:02d}" if left else f"{hours} h") if hours else f"{left} min"


def format_field_value(name: str, said: Any) -> str:
    """What was said of a field."""
    if isinstance(said, datetime):
        return format_long_time(said)
    if name == "time_factor":
        return "× " + format_number(round(float(said), 2)) if said != 1 else "temps ordinaire"
    if name == "excused":
        return "dispensé" if said else "non dispensé"
    return EMPTY_VALUES.get(name, "—")
