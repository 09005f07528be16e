"""Match the lines of a list with the members of a class and with existing accounts. Nothing is guessed."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from uuid import UUID

from server.base.errors import Invalid
from server.classes.folding import normalise_name
from server.classes.models import ClassRole, Membership, Status
from server.classes.roster_line import RejectedLine, RosterLine
from server.classes.schemas import Member
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


@dataclass
class MemberMatcher:
    """Matches the lines of a list with the members of a class and with existing accounts."""

    members: Sequence[Member]
    accounts: Mapping[str, Account]
    own_students: Collection[UUID]
    has_groups: bool
    accepts_everyone: bool
    matched: dict[UUID, int] = field(default_factory=dict)
    ambiguous: set[UUID] = field(default_factory=set)
    lines_by_name: Counter[str] = field(default_factory=Counter)

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
            members[_name_order_free_key(member.plain_name)].append(member)
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
            None if line.login else self.by_email.get(line.email) or self.by_login.get(line.account_login)
        )
        if certain is not None:
            return certain
        namesakes = self.by_name.get(_name_order_free_key(line.name), [])
        if not namesakes:
            return None
        self.ambiguous.update(member.id for member in namesakes)
        if len(namesakes) > 1:
            return self._match_namesakes(line, namesakes)
        namesake = namesakes[0]
        if line.login and namesake.account.login:
            raise Invalid(SAME_NAME.format(login=namesake.account.login))
        if line.email and namesake.membership.email and not line.login:
            return None  # two addresses under one name: two people
        return namesake

    def count_namesakes(self, lines: Sequence[RosterLine]) -> None:
        """Count the lines of each name that have neither login nor e-mail."""
        self.lines_by_name = Counter(_name_order_free_key(line.name) for line in lines if not line.account_login)

    def _match_namesakes(self, line: RosterLine, namesakes: Sequence[Member]) -> Member:
        """Return the namesake whom the line does not change, where the list has as many of them. Raises Invalid."""
        free = (member for member in namesakes if member.id not in self.matched and not self.would_change(line, member))
        same = next(free, None)
        if same is None or line.account_login or self.lines_by_name[_name_order_free_key(line.name)] != len(namesakes):
            raise Invalid(SEVERAL)
        return same

    def mark_ambiguous(self, rejected: RejectedLine) -> None:
        """Mark the members that a rejected line may mean, so that they stay in the class."""
        member = self.by_login.get(rejected.login)
        namesakes = self.by_name.get(_name_order_free_key(rejected.name), []) if rejected.name else []
        self.ambiguous.update(each.id for each in ([member] if member else namesakes))

    def find_outside_account(self, line: RosterLine) -> Account | None:
        """Return the account of a line outside the class. Raises Invalid where it may not be added."""
        account = self.accounts.get(line.account_login)
        if account is not None and not (self.accepts_everyone or account.id in self.own_students):
            raise Invalid(EXISTS.format(login=account.login))
        return account

    def would_change(self, line: RosterLine, member: Member) -> bool:
        """Whether the import of this line would change the member."""
        fields = merge_list_fields(line, member.membership, self.has_groups)
        return member.status is not Status.active or fields != stored_list_fields(member.membership)


ListFields = tuple[str, str, str, list[str]]


def stored_list_fields(membership: Membership) -> ListFields:
    return membership.family_name, membership.given_name, membership.email, list(membership.groups)


def merge_list_fields(line: RosterLine, membership: Membership, has_groups: bool) -> ListFields:
    """Return the fields of the membership after the import: an empty cell keeps the known value."""
    return (
        line.family_name or membership.family_name,
        line.given_name or membership.given_name,
        line.email or membership.email,
        list(line.groups) if has_groups else list(membership.groups),
    )


def _name_order_free_key(name: str) -> str:
    """Return a key equal for « LOVELACE Ada » and « Ada Lovelace »."""
    return " ".join(sorted(normalise_name(name).split())) or name
