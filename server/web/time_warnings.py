"""Say what a teacher may not have meant by the dates of an assignment: it is saved all the same, and not in silence."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from datetime import datetime, timedelta
from uuid import UUID

from sqlalchemy.orm import Session

from server.assignments import repository, sitting_repository
from server.assignments.models import Assignment, Exemption, LatePolicy, Mode, Visibility
from server.assignments.rules import Rules, SendingWindow, is_sitting_running, rules_in_force
from server.classes import repository as classes
from server.classes.models import ClassRole, Status
from server.classes.schemas import Member
from server.database import utc_now
from server.text.plain import show_invisible_characters
from server.web.words import count_with_noun, format_long_time

NOBODY = UUID(int=0)
MOST_SHOWN = 12
HIDDEN_FOREVER = "{what} attend {until}, et le devoir n’en a pas : il ne sera jamais montré."


def load_time_warnings(db: Session, assignment: Assignment) -> Sequence[str]:
    """Return the warnings on an assignment, in French sentences."""
    exemptions = repository.load_exemptions(db, [assignment.id]).get(assignment.id, ())
    members = classes.load_members(db, assignment.class_id) if exemptions or assignment.groups else ()
    return compute_time_warnings(db, assignment, exemptions, members)


def compute_time_warnings(
    db: Session, assignment: Assignment, exemptions: Collection[Exemption], members: Collection[Member]
) -> Sequence[str]:
    """Return the warnings on an assignment, in French sentences. `exemptions`: all of it, revoked ones included.

    One query for a test, none else.
    """
    active = [each for each in exemptions if each.revoked_at is None]
    names = {member.id: (member.name, member.groups) for member in members}
    students = [
        member.groups for member in members if member.role is ClassRole.student and member.status is Status.active
    ]
    rules = rules_in_force(assignment, (), NOBODY, ())
    warnings = [
        *_warn_about_past_dates(
            rules, assignment.past_rules[-1].until if assignment.past_rules else assignment.created_at
        ),
        *_warn_about_date_order(rules),
        *_warn_about_hidden_assignment(assignment, rules),
        *_warn_about_empty_groups(assignment, students),
        *_warn_about_longer_sittings(db, assignment, exemptions, utc_now()),
        *_warn_about_exemptions(assignment, rules, active, names),
    ]
    more = len(warnings) - MOST_SHOWN
    return (
        warnings
        if more <= 0
        else [*warnings[:MOST_SHOWN], f"Et {count_with_noun(more, 'autre remarque')} de ce genre."]
    )


def _warn_about_past_dates(rules: Rules, saved_at: datetime) -> Iterator[str]:
    """Dates that were over as they were saved."""
    end = rules.latest_counting_time
    if end is not None and end <= saved_at:
        past = f"Tout est déjà passé, depuis le {format_long_time(end)} : "
        yield past + (
            "personne ne commence plus ce contrôle." if rules.is_test else "rien de ce qui s’envoie ne compte."
        )
    elif rules.due_at is not None and rules.due_at <= saved_at:
        date = "La date pour commencer" if rules.is_test else "La date de remise"
        yield f"{date} est déjà passée ({format_long_time(rules.due_at)}) : tout ce qui vient est en retard."


def _warn_about_date_order(rules: Rules) -> Iterator[str]:
    opens, due, closes, duration = rules.opens_at, rules.due_at, rules.closes_at, rules.duration
    if duration is not None and closes is not None:
        if closes - opens < duration:
            yield (
                f"Le contrôle dure {_format_duration(duration)} et n’est ouvert que "
                f"{_format_duration(closes - opens)} : personne n’aura tout son temps."
            )
        elif (SendingWindow(rules).ends_at or closes) > closes - duration:
            yield (
                f"Un élève qui commence après le {format_long_time(closes - duration)} n’aura pas tout son temps : le "
                f"contrôle ferme le {format_long_time(closes)}."
            )
    if rules.is_test and duration is None and closes is None and due is not None:
        yield ("Rien ne met fin à ce contrôle : sa date dit jusqu’à quand il se commence. Donnez-lui une durée.")
    if due is not None and closes is not None and closes <= due and rules.late is not LatePolicy.refuse:
        yield "La règle de retard ne s’appliquera jamais : le devoir ferme à la date de remise."
    if (
        due is not None
        and closes is not None
        and closes > due
        and rules.late is LatePolicy.refuse
        and not rules.is_test
    ):
        yield "La fermeture ne change rien : ce qui vient après la date de remise est refusé."


def _format_duration(duration: timedelta) -> str:
    minutes = max(0, round(duration.total_seconds() / 60))
    days, rest = divmod(minutes, 24 * 60)
    parts = [f"{days} j"] if days else []
    parts += [f"{rest // 60} h"] if rest >= 60 else []
    return " ".join([*parts, f"{rest % 60} min"]) if rest % 60 or not parts else " ".join(parts)


def _warn_about_hidden_assignment(assignment: Assignment, rules: Rules) -> Iterator[str]:
    shown = (
        ("Les indices", assignment.hints),
        ("Le diagnostic", assignment.diagnosis),
        ("Le corrigé", assignment.solution),
    )
    for what, visibility in shown:
        if visibility == Visibility.after_close and rules.closes_at is None:
            yield HIDDEN_FOREVER.format(what=what, until="la fermeture")
        elif visibility == Visibility.after_due and rules.due_at is None and rules.closes_at is None:
            yield HIDDEN_FOREVER.format(what=what, until="la date de remise")


def _warn_about_empty_groups(assignment: Assignment, students: Collection[Collection[str]]) -> Iterator[str]:
    """Groups without students: the assignment is given to nobody there."""
    empty = [
        f"« {show_invisible_characters(label)} »"
        for label in assignment.groups
        if not any(label in own for own in students)
    ]
    if len(empty) == len(assignment.groups) and empty:
        yield f"Personne n’est dans le groupe {' ni dans '.join(empty)} : ce devoir n’est donné à aucun élève."
    elif empty:
        yield f"Personne n’est dans le groupe {' ni dans '.join(empty)}."


def _warn_about_longer_sittings(
    db: Session, assignment: Assignment, exemptions: Collection[Exemption], now: datetime
) -> Iterator[str]:
    """Students who sit the test until an end that they were told, later than that of today's rules."""
    if assignment.mode != Mode.test:
        return
    ends = []
    for unfinished in sitting_repository.load_unfinished_sittings(db, assignment.id):
        sitting = unfinished.sitting
        rules = rules_in_force(assignment, exemptions, sitting.account_id, unfinished.groups)
        told, today = (
            rules.latest_sitting_end(sitting.began_at),
            rules.without_earlier_rules.latest_sitting_end(sitting.began_at),
        )
        if told is not None and told != today and is_sitting_running(rules, sitting, now):
            ends.append(told)
    if ends:
        who = count_with_noun(len(ends), "élève compose", "élèves composent")
        end = format_long_time(max(ends))
        yield f"{who} jusqu’à la fin qui a déjà été annoncée, au plus tard le {end} : elle n’est pas avancée."


def _warn_about_exemptions(
    assignment: Assignment,
    common: Rules,
    active: Collection[Exemption],
    names: Mapping[UUID, tuple[str, Collection[str]]],
) -> Iterator[str]:
    for each in active:
        if each.account_id is None:
            who, rules = (
                f"Le groupe « {show_invisible_characters(each.label or '')} »",
                _rules_of_exempted_group(assignment, active, each.label or ""),
            )
        elif each.account_id in names:
            name, groups = names[each.account_id]
            who, rules = show_invisible_characters(name), rules_in_force(assignment, active, each.account_id, groups)
        else:
            continue
        if not rules.is_concerned:
            yield f"{who} : le devoir est donné à d’autres groupes ; cet aménagement ne change rien."
        elif not rules.excused:
            yield from _warn_about_less_time(who, rules, common)
            yield from _warn_about_useless_extension(who, each, rules, common)


def _rules_of_exempted_group(assignment: Assignment, active: Collection[Exemption], label: str) -> Rules:
    return rules_in_force(assignment, active, NOBODY, (label,))


def _warn_about_less_time(name: str, rules: Rules, common: Rules) -> Iterator[str]:
    due = "à commencer avant" if rules.is_test else "à rendre avant"
    for what, own, others in (
        (due, rules.due_at, common.due_at),
        ("fermeture", rules.closes_at, common.closes_at),
    ):
        if own is not None and (others is None or own < others):
            said = f"le {format_long_time(others)}" if others else "aucune date"
            yield f"{name} a moins de temps que la classe : {what} le {format_long_time(own)} (pour la classe, {said})."
    if rules.closes_at is not None and rules.closes_at <= rules.opens_at:
        yield (
            f"{name} ne peut rien envoyer qui compte : ouverture le {format_long_time(rules.opens_at)}, fermeture le "
            f"{format_long_time(rules.closes_at)}."
        )


def _warn_about_useless_extension(name: str, exemption: Exemption, rules: Rules, common: Rules) -> Iterator[str]:
    """An extension that the dates of the class have overtaken, or extra time where there is no time to extend."""
    if exemption.extends:
        for what, own, others in (
            ("date de remise", exemption.due_at, common.due_at),
            ("fermeture", exemption.closes_at, common.closes_at),
        ):
            if own is not None and (others is None or own < others):
                said = f"celle de la classe, le {format_long_time(others)}, vaut" if others else "la classe n’en a plus"
                yield f"{name} : la {what} accordée, le {format_long_time(own)}, ne prolonge plus rien ; {said}."
    if exemption.time_factor is not None and exemption.time_factor > 1 and common.duration is None:
        if not rules.is_test:
            yield f"{name} : le temps en plus ne change rien, car ce devoir n’est pas un contrôle."
        elif rules.closes_at is None:
            yield f"{name} : le temps en plus ne change rien, car ce contrôle n’a ni durée ni fermeture."
