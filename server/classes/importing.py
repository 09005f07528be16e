"""From a list to a class: what would change, then the change. Nobody is deleted, and nothing is guessed.

A line is of a member whom the same login tells, else the same e-mail in this class, else the same name. Where that may
be somebody else the line is rejected and its reason told: the teacher knows, a program does not. An account that the
list has not made is taken in only where its owner is a student of this teacher's already: whoever knows a login could
read what its owner has done.
"""

from __future__ import annotations

import hashlib
import json
from collections import defaultdict
from collections.abc import Collection, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from datetime import datetime
from functools import cached_property
from uuid import UUID

from sqlalchemy.orm import Session

from server.base.errors import Invalid
from server.classes import repository
from server.classes.models import ClassRole, Membership, SchoolClass, Status
from server.classes.roster import RejectedLine, Roster, RosterLine, normalise_name
from server.classes.schemas import Member
from server.identity import service as identity
from server.identity.models import Account
from server.identity.schemas import LOGIN_LENGTH

SAME_NAME = (
    "un membre de la classe porte ce nom avec l’identifiant « {login} ». Si c’est la même personne, laissez la case "
    "vide ou mettez cet identifiant ; sinon, donnez-lui le code de la classe."
)
SEVERAL = "plusieurs membres de la classe portent ce nom : ajoutez leur identifiant."
SAME_MEMBER = "c’est le même membre de la classe qu’à la ligne {line}."
WENT = "cette personne a quitté la classe d’elle-même : elle y revient avec le code."
IS_STAFF = "cette personne enseigne dans la classe."
EXISTS = (
    "l’identifiant « {login} » est celui d’un compte qui existe déjà : cette personne entre avec le code de la classe."
)


@dataclass(frozen=True)
class ImportPlan:
    """What a list would change. `back`, of those who change: who had left, or waited, and is in the class again."""

    added: tuple[RosterLine, ...] = ()
    joining: tuple[tuple[RosterLine, Account], ...] = ()
    updated: tuple[tuple[RosterLine, Member], ...] = ()
    unchanged: tuple[RosterLine, ...] = ()
    left: tuple[Member, ...] = ()
    rejected: tuple[RejectedLine, ...] = ()
    ignored: tuple[str, ...] = ()
    has_groups: bool = False

    @cached_property
    def digest(self) -> str:
        """The same for two plans that change the same."""
        told = [
            [asdict(line) for line in self.added],
            [[asdict(line), str(account.id)] for line, account in self.joining],
            [[asdict(line), str(member.id), member.status] for line, member in self.updated],
            sorted(str(member.id) for member in self.left),
        ]
        return hashlib.sha256(json.dumps(told, sort_keys=True).encode()).hexdigest()


@dataclass
class _MemberMatcher:
    """The members of a class, to be found by what a line says."""

    members: Sequence[Member]
    accounts: Mapping[str, Account]
    pupils: Collection[UUID]
    has_groups: bool
    all_pupils: bool
    taken: dict[UUID, int] = field(default_factory=dict)
    in_doubt: set[UUID] = field(default_factory=set)

    @cached_property
    def by_login(self) -> Mapping[str, Member]:
        return {member.account.login: member for member in self.members if member.account.login}

    @cached_property
    def by_email(self) -> Mapping[str, Member]:
        return {member.membership.email: member for member in self.members if member.membership.email}

    @cached_property
    def by_name(self) -> Mapping[str, list[Member]]:
        found: dict[str, list[Member]] = defaultdict(list)
        for member in self.members:
            found[_key(member.name)].append(member)
        return found

    def member_of(self, line: RosterLine) -> Member | None:
        """Raises Invalid where it may be somebody else."""
        member = self._found(line)
        if member is None:
            return None
        if member.role is not ClassRole.student:
            raise Invalid(IS_STAFF)
        if member.status is Status.left and member.membership.left_voluntarily:
            raise Invalid(WENT)
        if member.id in self.taken:
            raise Invalid(SAME_MEMBER.format(line=self.taken[member.id]))
        self.taken[member.id] = line.line
        return member

    def _found(self, line: RosterLine) -> Member | None:
        certain = self.by_login.get(line.login) or (
            None if line.login else self.by_email.get(line.email) or self.by_login.get(line.email)
        )
        if certain is not None:
            return certain
        same = self.by_name.get(_key(line.name), [])
        if not same:
            return None
        self.in_doubt.update(member.id for member in same)
        if len(same) > 1:
            raise Invalid(SEVERAL)
        if line.login and same[0].account.login:
            raise Invalid(SAME_NAME.format(login=same[0].account.login))
        if line.email and same[0].membership.email and not line.login:
            return None  # two addresses under one name: two people
        return same[0]

    def doubt(self, rejected: RejectedLine) -> None:
        """Who may be meant by a line that was not read has not left."""
        member = self.by_login.get(rejected.login)
        same = self.by_name.get(_key(rejected.name), []) if rejected.name else []
        self.in_doubt.update(one.id for one in ([member] if member else same))

    def account_of(self, line: RosterLine) -> Account | None:
        """The account outside of the class that this line is of. Raises Invalid where it may not be taken in."""
        account = self.accounts.get(line.login or line.email)
        if account is not None and not (self.all_pupils or account.id in self.pupils):
            raise Invalid(EXISTS.format(login=account.login))
        return account

    def changes(self, line: RosterLine, member: Member) -> bool:
        return member.status is not Status.active or _written(line, member.membership, self.has_groups) != _kept(
            member.membership
        )


def plan_import(db: Session, school_class: SchoolClass, roster: Roster, by: Account) -> ImportPlan:
    """What this list would change in the class, were it written now by this account."""
    members = repository.load_members(db, school_class.id)
    wanted = {line.login or line.email for line in roster.lines} - {""}
    pupils = repository.load_student_ids_of_teacher(db, by.id)
    accounts = repository.load_accounts_by_login(db, wanted)
    matching = _MemberMatcher(members, accounts, pupils, roster.has_groups, by.is_administrator)
    added, joining, updated, unchanged = [], [], [], []
    rejected = list(roster.rejected)
    for line in roster.lines:
        try:
            member = matching.member_of(line)
            if member is not None:
                (updated.append((line, member)) if matching.changes(line, member) else unchanged.append(line))
                continue
            account = matching.account_of(line)
            (added.append(line) if account is None else joining.append((line, account)))
        except Invalid as problem:
            rejected.append(RejectedLine(line.line, problem.detail))
    for one in roster.rejected:
        matching.doubt(one)
    kept = matching.taken.keys() | matching.in_doubt
    accepted = bool(added or joining or updated or unchanged)
    left = [
        member
        for member in members
        if accepted and member.role is ClassRole.student and member.status is Status.active and member.id not in kept
    ]
    rejected.sort(key=lambda one: one.line)
    return ImportPlan(
        tuple(added), tuple(joining), tuple(updated), tuple(unchanged), tuple(left), tuple(rejected),
        roster.ignored, roster.has_groups,
    )  # fmt: skip


def apply_import(db: Session, school_class: SchoolClass, planned: ImportPlan, now: datetime) -> None:
    """Writes it, in the transaction in which it was planned, the class locked before."""
    logins = _new_logins(db, planned.added)
    for line in planned.added:
        account = identity.create_for_roster(db, logins[line.line], line.name)
        _enter(db, school_class, account, line, now, created_by_list=True)
    for line, account in planned.joining:
        _enter(db, school_class, account, line, now, created_by_list=False)
    for line, member in planned.updated:
        membership = member.membership
        (
            membership.family_name,
            membership.given_name,
            membership.email,
            membership.groups,
        ) = _written(line, membership, planned.has_groups)
        membership.status, membership.left_at = Status.active, None
    for member in planned.left:
        member.membership.status, member.membership.left_at = Status.left, now
    db.flush()


def _enter(
    db: Session, school_class: SchoolClass, account: Account, line: RosterLine, now: datetime, *, created_by_list: bool
) -> None:
    db.add(
        Membership(
            class_id=school_class.id,
            account_id=account.id,
            role=ClassRole.student,
            status=Status.active,
            family_name=line.family_name,
            given_name=line.given_name,
            email=line.email,
            groups=list(line.groups),
            created_by_list=created_by_list,
            joined_at=now,
        )
    )


Written = tuple[str, str, str, list[str]]


def _kept(membership: Membership) -> Written:
    return membership.family_name, membership.given_name, membership.email, list(membership.groups)


def _written(line: RosterLine, membership: Membership, has_groups: bool) -> Written:
    """What the membership holds once the line is written: an empty cell leaves what is known."""
    return (
        line.family_name or membership.family_name,
        line.given_name or membership.given_name,
        line.email or membership.email,
        list(line.groups) if has_groups else list(membership.groups),
    )


def _key(name: str) -> str:
    """The same for « LOVELACE Ada » and « Ada Lovelace »."""
    return " ".join(sorted(normalise_name(name).split())) or name


def _new_logins(db: Session, lines: Sequence[RosterLine]) -> Mapping[int, str]:
    """The login of each new account: the list's, else the address, else one made of the name that is free."""
    logins = {line.line: line.login or line.email for line in lines if line.login or line.email}
    made = {line.line: _made_login(line) for line in lines if line.line not in logins}
    used = {*logins.values(), *repository.load_accounts_by_login(db, set(made.values()))}
    for place, base in made.items():
        login, number = base, 1
        while login in used or (number > 1 and repository.load_accounts_by_login(db, [login])):
            number += 1
            login = f"{base}{number}"
        used.add(login)
        logins[place] = login
    return logins


def _made_login(line: RosterLine) -> str:
    """prenom.nom, without accents."""
    parts = (normalise_name(part).replace(" ", "-") for part in (line.given_name, line.family_name))
    made = ".".join(filter(None, parts))[: LOGIN_LENGTH.stop - 10]
    return made if len(made) >= LOGIN_LENGTH.start else f"eleve.{made}"
