"""Import a list into a class: plan the changes, then apply them. Nobody is deleted, and nothing is guessed.

A line matches the member with the same login, else the same e-mail in this class, else the same name. An ambiguous line
is rejected with its reason. An existing account is added only where its owner is a student of this teacher already:
otherwise, whoever knows a login could read its owner's work.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from datetime import datetime
from functools import cached_property

from sqlalchemy.orm import Session

from server.base.errors import Invalid
from server.classes import repository
from server.classes.class_routes import split_lines_by_class
from server.classes.folding import normalise_name
from server.classes.matching import MemberMatcher, merge_list_fields
from server.classes.models import ClassRole, Membership, SchoolClass, Status
from server.classes.roster import AS_WRITTEN, ReadingChoice, Roster
from server.classes.roster_line import RejectedLine, RosterLine
from server.classes.schemas import Member
from server.identity import service as identity
from server.identity.logins import LOGIN_LENGTH, login_problem, normalise_login
from server.identity.models import Account


@dataclass(frozen=True)
class ImportPlan:
    """The changes that a list makes to a class, and to other classes of the teacher that it names.

    `left`: who leaves, when the list replaces the class; `staying`: who is not in the list and stays. `others`: the
    plans of the other classes, to which a list only adds. `skipped`: values of its column of classes that are no class
    of the teacher, with their numbers of lines.
    """

    school_class: SchoolClass
    roster: Roster
    choice: ReadingChoice = AS_WRITTEN
    added: tuple[RosterLine, ...] = ()
    joining: tuple[tuple[RosterLine, Account], ...] = ()
    updated: tuple[tuple[RosterLine, Member], ...] = ()
    unchanged: tuple[RosterLine, ...] = ()
    left: tuple[Member, ...] = ()
    staying: tuple[Member, ...] = ()
    rejected: tuple[RejectedLine, ...] = ()
    warnings: tuple[str, ...] = ()
    others: tuple[ImportPlan, ...] = ()
    values: tuple[str, ...] = ()
    skipped: Mapping[str, int] = field(default_factory=dict)

    @property
    def ignored_headers(self) -> tuple[str, ...]:
        return self.roster.ignored_headers

    @property
    def has_changes(self) -> bool:
        """Whether anything would be written."""
        here = bool(self.added or self.joining or self.updated or self.left)
        return here or any(plan.has_changes for plan in self.others)

    @cached_property
    def digest(self) -> str:
        """A hash of the changes: equal plans have equal digests."""
        changes = [
            str(self.school_class.id),
            [asdict(line) for line in self.added],
            [[asdict(line), str(account.id)] for line, account in self.joining],
            [[asdict(line), str(member.id), member.status] for line, member in self.updated],
            sorted(str(member.id) for member in self.left),
            [plan.digest for plan in self.others],
        ]
        return hashlib.sha256(json.dumps(changes, sort_keys=True).encode()).hexdigest()


def plan_import(
    db: Session,
    school_class: SchoolClass,
    roster: Roster,
    by: Account,
    choice: ReadingChoice = AS_WRITTEN,
    *,
    replace: bool = False,
) -> ImportPlan:
    """Plan the changes of a list, as imported by this account. `replace`: who is not in it leaves this class."""
    taught = [] if choice.only_here else repository.load_taught_classes(db, by.id)
    routes = split_lines_by_class(roster, school_class, [each for each in taught if each.id != school_class.id], choice)
    others = tuple(
        _plan_class_import(db, other, roster, lines, by, replace=False, is_first=False)
        for other, lines in routes.elsewhere.values()
    )
    plan = _plan_class_import(db, school_class, roster, routes.here, by, replace=replace, is_first=True)
    warnings = (*roster.warnings, *routes.warnings)
    return dataclasses.replace(
        plan, choice=choice, others=others, warnings=warnings, values=routes.values, skipped=routes.skipped
    )


def _plan_class_import(
    db: Session,
    school_class: SchoolClass,
    roster: Roster,
    lines: Sequence[RosterLine],
    by: Account,
    *,
    replace: bool,
    is_first: bool,
) -> ImportPlan:
    """Plan the changes of one class. The first one has the lines that could not be read."""
    members = repository.load_members(db, school_class.id)
    logins = {line.account_login for line in lines} - {""}
    own_students = repository.load_student_ids_of_teacher(db, by.id)
    accounts = repository.load_accounts_by_login(db, logins)
    matching = MemberMatcher(members, accounts, own_students, roster.has_groups, by.is_administrator)
    matching.count_namesakes(lines)
    added, joining, updated, unchanged = [], [], [], []
    rejected = list(roster.rejected) if is_first else []
    for line in lines:
        try:
            member = matching.match_member(line)
            if member is not None:
                (updated.append((line, member)) if matching.would_change(line, member) else unchanged.append(line))
                continue
            account = matching.find_outside_account(line)
            (added.append(line) if account is None else joining.append((line, account)))
        except Invalid as problem:
            rejected.append(RejectedLine(line.line, problem.detail, line.name, line.login))
    for line_rejected in roster.rejected:
        matching.mark_ambiguous(line_rejected)
    mentioned = matching.matched.keys() | matching.ambiguous
    accepted = bool(added or joining or updated or unchanged)
    missing = tuple(
        member
        for member in members
        if accepted
        and member.role is ClassRole.student
        and member.status is Status.active
        and member.id not in mentioned
    )
    rejected.sort(key=lambda rejection: rejection.line)
    return ImportPlan(
        school_class, roster, AS_WRITTEN, tuple(added), tuple(joining), tuple(updated), tuple(unchanged),
        missing if replace else (), () if replace else missing, tuple(rejected),
    )  # fmt: skip


def apply_import(db: Session, planned: ImportPlan, now: datetime) -> None:
    """Apply the plan of one class in the transaction that made it, with the class locked."""
    school_class = planned.school_class
    logins = _choose_new_logins(db, planned.added)
    for line in planned.added:
        account = identity.create_account_for_roster(db, logins[line.line], line.name)
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
        ) = merge_list_fields(line, membership, planned.roster.has_groups)
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


def _choose_new_logins(db: Session, lines: Sequence[RosterLine]) -> Mapping[int, str]:
    """Return the login of each new account by line: the list's, else the e-mail, else a free one made from the name."""
    logins = {line.line: line.account_login for line in lines if line.account_login}
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
    """Return `prenom.nom` without accents; `eleve` for a name that mixes alphabets."""
    parts = (normalise_name(part).replace(" ", "-") for part in (line.given_name, line.family_name))
    login = normalise_login(".".join(filter(None, parts)))[: LOGIN_LENGTH.stop - 10]
    login = login if len(login) >= LOGIN_LENGTH.start else f"eleve.{login}"
    return "eleve" if login_problem(login) else login
