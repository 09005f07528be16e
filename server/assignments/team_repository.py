"""Queries on the teams of assignments, and on proposals to hand in together."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Mapping, Sequence
from datetime import datetime
from typing import Any
from uuid import UUID

from sqlalchemy import Row, Select, and_, delete, or_, select, update
from sqlalchemy.orm import InstrumentedAttribute, Session, aliased

from server.assignments.models import AssignedExercise, Assignment, TeamMember, TeamProposal
from server.assignments.team_rules import TeamPlace
from server.classes.models import Membership, SchoolClass
from server.classes.schemas import display_name
from server.identity.models import Account

#: Two places in one team: somebody's, and a partner's.
MINE, OTHER = aliased(TeamMember), aliased(TeamMember)


def load_team_places(db: Session, assignments: Collection[UUID]) -> Mapping[UUID, tuple[TeamPlace, ...]]:
    """Load the places in teams of each assignment, ended ones included, oldest first."""
    query = (
        select(TeamMember, Membership.given_name, Membership.family_name, Account.name, Membership.groups)
        .join(Assignment, Assignment.id == TeamMember.assignment_id)
        .join(Account, Account.id == TeamMember.account_id)
        .outerjoin(
            Membership,
            and_(Membership.class_id == Assignment.class_id, Membership.account_id == TeamMember.account_id),
        )
        .where(TeamMember.assignment_id.in_(assignments))
        .order_by(TeamMember.since, TeamMember.id)
    )
    places: dict[UUID, list[TeamPlace]] = defaultdict(list)
    for member, given, family, name, groups in db.execute(query) if assignments else ():
        places[member.assignment_id].append(
            TeamPlace(
                member.team_id,
                member.account_id,
                member.since,
                member.until,
                display_name(given, family, name),
                tuple(groups or ()),
            )
        )
    return {assignment: tuple(rows) for assignment, rows in places.items()}


def load_places_of_team_assignments(
    db: Session, assignments: Collection[Assignment]
) -> Mapping[UUID, tuple[TeamPlace, ...]]:
    """Load the places of those assignments that are handed in by teams: without any, no query is made."""
    return load_team_places(db, [assignment.id for assignment in assignments if assignment.team_size > 1])


def load_current_members(db: Session, assignment_id: UUID) -> Sequence[TeamMember]:
    query = select(TeamMember).where(TeamMember.assignment_id == assignment_id, TeamMember.until.is_(None))
    return db.execute(query.order_by(TeamMember.since, TeamMember.id)).scalars().all()


def select_teammate_pairs(*columns: Any) -> Select[*tuple[Any, ...]]:
    """Select columns of two places in one team, `MINE` and `OTHER`, and of their assignment, which is joined."""
    pair = and_(
        OTHER.team_id == MINE.team_id,
        OTHER.assignment_id == MINE.assignment_id,
        OTHER.account_id != MINE.account_id,
    )
    return select(*columns).select_from(MINE).join(OTHER, pair).join(Assignment, Assignment.id == MINE.assignment_id)


def join_partner_names(pairs: Select[*tuple[Any, ...]]) -> Select[*tuple[Any, ...]]:
    """Join the account of `OTHER`, and its membership of the assignment's class, which may have ended."""
    membership = and_(Membership.class_id == Assignment.class_id, Membership.account_id == OTHER.account_id)
    return pairs.join(Account, Account.id == OTHER.account_id).outerjoin(Membership, membership)


def select_shared_work(at: datetime | InstrumentedAttribute[datetime], *columns: Any) -> Select[*tuple[Any, ...]]:
    """Select columns of the pairs that are held at a time, each with an exercise that its assignment asks."""
    return (
        select_teammate_pairs(*columns)
        .join(AssignedExercise, AssignedExercise.assignment_id == MINE.assignment_id)
        .where(
            Assignment.removed_at.is_(None),
            *(place.since <= at for place in (MINE, OTHER)),
            *(or_(place.until.is_(None), place.until > at) for place in (MINE, OTHER)),
        )
    )


def is_teammate(db: Session, reader: UUID, author: UUID, exercise: str, sent_at: datetime) -> bool:
    """Whether an attempt was sent while reader and author were in one team of an assignment that asks the exercise."""
    query = select_shared_work(sent_at, MINE.id).where(
        MINE.account_id == reader, OTHER.account_id == author, AssignedExercise.exercise == exercise
    )
    return db.execute(query.limit(1)).first() is not None


def find_teammate_name(db: Session, reader: UUID, author: UUID) -> str:
    """Return the name, in a class that they share, of somebody with whom the reader hands in, or handed in."""
    pairs = select_teammate_pairs(Membership.given_name, Membership.family_name, Account.name)
    query = join_partner_names(pairs).where(MINE.account_id == reader, OTHER.account_id == author)
    row = db.execute(query.limit(1)).first()
    return "" if row is None else display_name(*row)


def load_proposals(db: Session, assignment_id: UUID) -> Sequence[TeamProposal]:
    query = select(TeamProposal).where(TeamProposal.assignment_id == assignment_id)
    return db.execute(query.order_by(TeamProposal.proposed_at)).scalars().all()


def delete_proposals(db: Session, assignment_id: UUID, accounts: Collection[UUID]) -> None:
    """Delete the proposals that these accounts have made or received."""
    query = delete(TeamProposal).where(
        TeamProposal.assignment_id == assignment_id,
        or_(TeamProposal.account_id.in_(accounts), TeamProposal.partner_id.in_(accounts)),
    )
    db.execute(query.execution_options(synchronize_session="fetch"))


def load_team_history(db: Session, account_id: UUID) -> Sequence[Row[TeamMember, Assignment, str]]:
    """Load every place that an account had in a team, each with its assignment and the name of the class."""
    query = (
        select(TeamMember, Assignment, SchoolClass.name)
        .join(Assignment, Assignment.id == TeamMember.assignment_id)
        .join(SchoolClass, SchoolClass.id == Assignment.class_id)
        .where(TeamMember.account_id == account_id)
    )
    return db.execute(query.order_by(TeamMember.since, TeamMember.id)).all()


def load_account_proposals(db: Session, account_id: UUID) -> Sequence[Row[TeamProposal, str]]:
    """Load the proposals that an account has made or received, each with the title of its assignment."""
    query = select(TeamProposal, Assignment.title).join(Assignment, Assignment.id == TeamProposal.assignment_id)
    query = query.where(or_(TeamProposal.account_id == account_id, TeamProposal.partner_id == account_id))
    return db.execute(query.order_by(TeamProposal.proposed_at)).all()


def move_team_places(db: Session, old: UUID, new: UUID) -> None:
    """Move places from a guest to an account, which keeps its own where both have one; drop the proposals."""
    own = select(TeamMember.assignment_id).where(TeamMember.account_id == new, TeamMember.until.is_(None))
    moved = update(TeamMember).where(TeamMember.account_id == old, TeamMember.assignment_id.not_in(own))
    db.execute(moved.values(account_id=new).execution_options(synchronize_session=False))
    gone = delete(TeamProposal).where(or_(TeamProposal.account_id == old, TeamProposal.partner_id == old))
    db.execute(gone.execution_options(synchronize_session=False))
