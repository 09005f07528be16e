"""Import a list into a class: plan the changes, then apply them. Nobody is deleted, and nothing is guessed.

A line matches the member with the same login, else the same e-mail in this class, else the same name. An ambiguous line
is rejected with its reason. An existing account is added only where its owner is a student of this teacher already:
otherwise, whoever knows a login could read its owner's work.
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
from server.identity.logins import LOGIN_LENGTH
from server.identity.models import Account

SAME_NAME = (
    "un membre de la classe porte ce nom avec l’identifiant « {login} ». Si c’est la même personne, laissez la case "
    "vide ou mettez cet identifiant ; sinon, donnez-lui le code de la classe."
)
SEVERAL = "plusieurs membres de la classe portent ce nom : ajoutez leur identifiant."
SAME_MEMBER = "c’est le même membre de la classe qu’à la ligne {line}."
LEFT_VOLUNTARILY = "cette personne a quitté la classe d’elle-même : elle y revient avec le code."
IS_STAFF = "cette personne enseigne dans la classe."
EXISTS = (
    "l’identifiant « {login} » est celui d’un compte qui existe déjà : cette personne entre avec le code de la classe."
)


@dataclass(frozen=True)
class ImportPlan:
    """The changes that a list makes to a class."""

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
        """A hash of the changes: equal plans have equal digests."""
        changes = [
            [asdict(line) for line in self.added],
            [[asdict(line), str(account.id)] for line, account in self.joining],
            [[asdict(line), str(member.id), member.status] for line, member in self.updated],
            sorted(str(member.id) for member in self.left),
        ]
        return hashlib.sha256(json.dumps(changes, sort_keys=True).encode()).hexdigest()


@dataclass
class _MemberMatcher:
    """Matches the lines of a list with the members of a class and with existing accounts."""

    members: Sequence[Member]
    accounts: Mapping[str, Account]
    own_students: Collection[UUID]
    has_groups: bool
    accepts_everyone: bool
    matched: dict[UUID, int] = field(default_factory=dict)
    ambiguous: set[UUID] = field(default_factory=set)

    @cached_property
    def by_login(self) -> Mapping[str, Member]:
        return {member.account.login: member for member in self.members if member.account.login}

    @cached_property
    def by_email(self) -> Mapping[str, Member]:
        return {member.membership.email: member for member in self.members if member.membership.email}

    @cached_property
    def by_name(self) -> Mapping[str, list[Member]]:
        members: dict[str, list[Member]] = defaultdict(list)
        for member in self.members:
            members[_key(member.name)].append(member)
        return members

    def match_member(self, line: RosterLine) -> Member | None:
        """Return the member of a line, None for a new one. Raises Invalid for an ambiguous line."""
        member = self._find_member(line)
        if member is None:
            return None
        if member.role is not ClassRole.student:
            raise Invalid(IS_STAFF)
        if member.status is Status.left and member.membership.left_voluntarily:
            raise Invalid(LEFT_VOLUNTARILY)
        if member.id in self.matched:
            raise Invalid(SAME_MEMBER.format(line=self.matched[member.id]))
        self.matched[member.id] = line.line
        return member

    def _find_member(self, line: RosterLine) -> Member | None:
        certain = self.by_login.get(line.login) or (
            None if line.login else self.by_email.get(line.email) or self.by_login.get(line.email)
        )
        if certain is not None:
            return certain
        namesakes = self.by_name.get(_key(line.name), [])
        if not namesakes:
            return None
        self.ambiguous.update(member.id for member in namesakes)
        if len(namesakes) > 1:
            raise Invalid(SEVERAL)
        namesake = namesakes[0]
        if line.login and namesake.account.login:
            raise Invalid(SAME_NAME.format(login=namesake.account.login))
        if line.email and namesake.membership.email and not line.login:
            return None  # two addresses under one name: two people
        return namesake

    def mark_ambiguous(self, rejected: RejectedLine) -> None:
        """Mark the members that a rejected line may mean, so that they stay in the class."""
        member = self.by_login.get(rejected.login)
        namesakes = self.by_name.get(_key(rejected.name), []) if rejected.name else []
        self.ambiguous.update(each.id for each in ([member] if member else namesakes))

    def match_account(self, line: RosterLine) -> Account | None:
        """Return the account of a line outside the class. Raises Invalid where it may not be added."""
        account = self.accounts.get(line.login or line.email)
        if account is not None and not (self.accepts_everyone or account.id in self.own_students):
            raise Invalid(EXISTS.format(login=account.login))
        return account

    def changes(self, line: RosterLine, member: Member) -> bool:
        fields = _merged_fields(line, member.membership, self.has_groups)
        return member.status is not Status.active or fields != _list_fields(member.membership)


def plan_import(db: Session, school_class: SchoolClass, roster: Roster, by: Account) -> ImportPlan:
    """Plan the changes of a list, as imported by this account."""
    members = repository.load_members(db, school_class.id)
    logins = {line.login or line.email for line in roster.lines} - {""}
    own_students = repository.load_student_ids_of_teacher(db, by.id)
    accounts = repository.load_accounts_by_login(db, logins)
    matching = _MemberMatcher(members, accounts, own_students, roster.has_groups, by.is_administrator)
    added, joining, updated, unchanged = [], [], [], []
    rejected = list(roster.rejected)
    for line in roster.lines:
        try:
            member = matching.match_member(line)
            if member is not None:
                (updated.append((line, member)) if matching.changes(line, member) else unchanged.append(line))
                continue
            account = matching.match_account(line)
            (added.append(line) if account is None else joining.append((line, account)))
        except Invalid as problem:
            rejected.append(RejectedLine(line.line, problem.detail))
    for line_rejected in roster.rejected:
        matching.mark_ambiguous(line_rejected)
    mentioned = matching.matched.keys() | matching.ambiguous
    accepted = bool(added or joining or updated or unchanged)
    left = [
        member
        for member in members
        if accepted
        and member.role is ClassRole.student
        and member.status is Status.active
        and member.id not in mentioned
    ]
    rejected.sort(key=lambda rejection: rejection.line)
    return ImportPlan(
        tuple(added), tuple(joining), tuple(updated), tuple(unchanged), tuple(left), tuple(rejected),
        roster.ignored, roster.has_groups,
    )  # fmt: skip


def apply_import(db: Session, school_class: SchoolClass, planned: ImportPlan, now: datetime) -> None:
    """Apply a plan in the transaction that made it, with the class locked."""
    logins = _new_logins(db, planned.added)
    for line in planned.added:
        account = identity.create_for_roster(db, logins[line.line], line.name)
        _add_member(db, school_class, account, line, now, created_by_list=True)
    for line, account in planned.joining:
        _add_member(db, school_class, account, line, now, created_by_list=False)
    for line, member in planned.updated:
        membership = member.membership
        (
            membership.family_name,
            membership.given_name,
            membership.email,
            membership.groups,
        ) = _merged_fields(line, membership, planned.has_groups)
        membership.status, membership.left_at = Status.active, None
        membership.is_confirmed = membership.is_confirmed or not member.account.is_guest
    for member in planned.left:
        member.membership.status, member.membership.left_at = Status.left, now
    db.flush()


def _add_member(
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
            is_confirmed=True,
            joined_at=now,
        )
    )


ListFields = tuple[str, str, str, list[str]]


def _list_fields(membership: Membership) -> ListFields:
    return membership.family_name, membership.given_name, membership.email, list(membership.groups)


def _merged_fields(line: RosterLine, membership: Membership, has_groups: bool) -> ListFields:
    """Return the fields of the membership after the import: an empty cell keeps the known value."""
    return (
        line.family_name or membership.family_name,
        line.given_name or membership.given_name,
        line.email or membership.email,
        list(line.groups) if has_groups else list(membership.groups),
    )


def _key(name: str) -> str:
    """Return a key equal for « LOVELACE Ada » and « Ada Lovelace »."""
    return " ".join(sorted(normalise_name(name).split())) or name


def _new_logins(db: Session, lines: Sequence[RosterLine]) -> Mapping[int, str]:
    """Return the login of each new account by line: the list's, else the e-mail, else a free one made from the name."""
    logins = {line.line: line.login or line.email for line in lines if line.login or line.email}
    generated = {line.line: _login_from_name(line) for line in lines if line.line not in logins}
    used = {*logins.values(), *repository.load_accounts_by_login(db, set(generated.values()))}
    for line_number, base in generated.items():
        login, number = base, 1
        while login in used or (number > 1 and repository.load_accounts_by_login(db, [login])):
            number += 1
            login = f"{base}{number}"
        used.add(login)
        logins[line_number] = login
    return logins


def _login_from_name(line: RosterLine) -> str:
    """Return `prenom.nom` without accents."""
    parts = (normalise_name(part).replace(" ", "-") for part in (line.given_name, line.family_name))
    login = ".".join(filter(None, parts))[: LOGIN_LENGTH.stop - 10]
    return login if len(login) >= LOGIN_LENGTH.start else f"eleve.{login}"
