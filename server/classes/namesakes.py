"""Students of one class who have the same name, whatever the order and the accents of its words. Pure."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from uuid import UUID

from server.classes.folding import normalise_name
from server.classes.models import ClassRole
from server.classes.schemas import Member


def find_namesakes(members: Sequence[Member], account_id: UUID) -> Sequence[Member]:
    """Return the other students, former ones included, who have a name of this one in the class or in their account."""
    students = [member for member in members if member.role is ClassRole.student]
    own_keys = {key for member in students if member.id == account_id for key in _name_keys(member)}
    return [member for member in students if member.id != account_id and not own_keys.isdisjoint(_name_keys(member))]


def find_unconfirmed_namesakes(members: Sequence[Member]) -> frozenset[UUID]:
    """Return the students whom nothing but their own word tells from another one of their name."""
    students = [member for member in members if member.role is ClassRole.student]
    counts = Counter(key for member in students for key in _name_keys(member))
    return frozenset(
        member.id
        for member in students
        if not member.membership.is_confirmed and any(counts[key] > 1 for key in _name_keys(member))
    )


def _name_keys(member: Member) -> frozenset[str]:
    names = (member.plain_name, member.account.name)
    return frozenset(" ".join(sorted(normalise_name(name).split())) or name for name in names)
