"""The teams of an assignment: a page for its staff, another for the student who hands in with others."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from random import SystemRandom
from uuid import UUID

from fastapi import APIRouter, Request
from fastapi.responses import Response
from sqlalchemy.orm import Session

from server.assignments import editing, team_repository, teams
from server.assignments.groups import find_named_students
from server.assignments.models import Assignment
from server.assignments.student_assignments import load_student_assignment
from server.assignments.team_rules import TeamPlace, list_current_partners, list_partnerships, team_word
from server.base.errors import Conflict, Invalid, InvalidFields, NotFound
from server.base.validation import parse_uuid
from server.classes import repository as classes
from server.classes.folding import normalise_name
from server.classes.schemas import Member
from server.course import Course
from server.course.dependencies import CourseOf
from server.database import roll_back_then_read, utc_now
from server.database.dependencies import Db
from server.desk.assignments.views import TAB, assignment_href, may_manage
from server.desk.requests import ShortQuery
from server.desk.schemas import ClassHead
from server.desk.views import class_head
from server.gradebook import service as gradebook
from server.identity.dependencies import SignedIn
from server.identity.models import Account
from server.marks.service import load_visible_marks
from server.rights import service as rights
from server.rights.models import Right
from server.rights.service import ClassAccess
from server.web.dependencies import CurrentReader, PageNumber
from server.web.forms import UNKNOWN_ACTION, Field, redirect, redirect_to_login
from server.web.rendering import render_page
from server.web.views import Reader

router = APIRouter(include_in_schema=False)

ASSIGNMENT = "/classes/{class_id}/devoirs/{aid}"
TEAMS_A_PAGE = 20
MAX_LINES = 200
UNKNOWN_STUDENT = "Cette personne n’est pas un élève de la classe."
NOBODY = "Écrivez un binôme ou une équipe par ligne, les noms séparés par un point-virgule."


@dataclass(frozen=True)
class TeamRow:
    """A team of today, its members by name."""

    id: UUID
    members: tuple[str, ...]
    since: datetime


@dataclass(frozen=True)
class TeamsPage:
    """The teams of an assignment whose members' names contain `search`; `alone` are students without one."""

    head: ClassHead
    assignment: Assignment
    href: str
    word: str
    count: int
    shown: tuple[TeamRow, ...]
    alone: tuple[str, ...]
    search: str
    number: int
    more: bool
    may_change: bool
    typed: str = ""
    earlier: bool = False
    problem: str = ""


@router.get(f"{ASSIGNMENT}/equipes")
def show_teams(
    request: Request, class_id: str, aid: str, reader: CurrentReader, q: ShortQuery = "", page: PageNumber = 1
) -> Response:
    if reader.account is None:
        return redirect_to_login(request)
    access = rights.require_right(reader.db, reader.account, Right.see_students, class_id)
    assignment = editing.find_assignment(reader.db, access.school_class, aid)
    view = _build_page(reader.db, reader.course, access, assignment, q, page)
    return render_page(request, "classes/teams.html", reader.account, page=view)


def _build_page(
    db: Session,
    course: Course,
    access: ClassAccess,
    assignment: Assignment,
    search: str = "",
    number: int = 1,
    *,
    typed: str = "",
    earlier: bool = False,
    problem: str = "",
) -> TeamsPage:
    teams.require_team_assignment(assignment)
    rows = _team_rows(team_repository.load_team_places(db, [assignment.id]).get(assignment.id, ()))
    taken = {row.account_id for row in team_repository.load_current_members(db, assignment.id)}
    students = teams.load_eligible_students(db, assignment)
    wanted = normalise_name(search).split()
    matching = [row for row in rows if all(word in normalise_name(" ".join(row.members)) for word in wanted)]
    first = (number - 1) * TEAMS_A_PAGE
    return TeamsPage(
        head=class_head(course, access, TAB),
        assignment=assignment,
        href=assignment_href(assignment),
        word=team_word(assignment.team_size),
        count=len(rows),
        shown=tuple(matching[first : first + TEAMS_A_PAGE]),
        alone=tuple(student.name for account, student in students.items() if account not in taken),
        search=search,
        number=number,
        more=first + TEAMS_A_PAGE < len(matching),
        may_change=may_manage(access),
        typed=typed,
        earlier=earlier,
        problem=problem,
    )


def _team_rows(places: Sequence[TeamPlace]) -> list[TeamRow]:
    current = [place for place in places if place.until is None]
    ids = dict.fromkeys(place.team_id for place in current)
    rows = []
    for team_id in ids:
        members = sorted((place for place in current if place.team_id == team_id), key=lambda place: place.name)
        rows.append(TeamRow(team_id, tuple(member.name for member in members), max(m.since for m in members)))
    return sorted(rows, key=lambda row: row.members)


@router.post(f"{ASSIGNMENT}/equipes")
def change_teams(
    request: Request, class_id: str, aid: str, account: SignedIn, db: Db, course: CourseOf,
    action: Field = "", noms: Field = "", deja: Field = "", equipe: Field = "",
) -> Response:  # fmt: skip
    access = rights.require_right(db, account, Right.manage_assignments, class_id)
    school_class = access.school_class
    assignment = editing.find_assignment(db, school_class, aid, to_change=True)
    try:
        if action == "former":
            chosen = _read_teams(classes.load_members(db, school_class.id), noms)
            teams.form_teams(db, school_class, account.id, assignment, chosen, earlier=bool(deja))
        elif action == "hasard":
            teams.form_random_teams(db, school_class, account.id, assignment, SystemRandom())
        elif action == "defaire":
            teams.end_team(db, school_class, account.id, assignment, parse_uuid(equipe, UNKNOWN_ACTION))
        else:
            raise NotFound(UNKNOWN_ACTION)
    except (Invalid, InvalidFields, Conflict) as refused:
        roll_back_then_read(db)
        problem = " ".join(refused.problems.values()) if isinstance(refused, InvalidFields) else refused.detail
        view = _build_page(db, course, access, assignment, typed=noms, earlier=bool(deja), problem=problem)
        return render_page(request, "classes/teams.html", account, status=422, page=view)
    return redirect(f"{assignment_href(assignment)}/equipes")


def _read_teams(members: Sequence[Member], text: str) -> Sequence[Sequence[UUID]]:
    """Return the students of each line. Raise InvalidFields for names of nobody, or of several."""
    lines = [line for line in text.splitlines() if line.strip(" ;")][:MAX_LINES]
    if not lines:
        raise InvalidFields({"names": NOBODY})
    return [find_named_students(members, line.replace(";", "\n")) for line in lines]


@dataclass(frozen=True)
class SharedAttempt:
    """An attempt that counts for all members of a team: who sent it, and its exercise."""

    href: str
    title: str
    name: str
    sent_at: datetime


@dataclass(frozen=True)
class OwnTeamPage:
    """A student's own team: partners, proposals received and made, and the attempts that partners sent for both.

    `received` and `made` are classmates by id; `free` those who have no team, by name.
    """

    head: ClassHead
    assignment: Assignment
    href: str
    word: str
    partners: tuple[TeamPlace, ...]
    former: tuple[str, ...]
    received: tuple[tuple[UUID, str], ...]
    made: tuple[tuple[UUID, str], ...]
    free: tuple[tuple[UUID, str], ...]
    attempts: tuple[SharedAttempt, ...]
    may_choose: bool
    may_add: bool
    problem: str = ""


@router.get(f"{ASSIGNMENT}/mon-equipe")
def show_own_team(request: Request, class_id: str, aid: str, reader: CurrentReader) -> Response:
    if reader.account is None:
        return redirect_to_login(request)
    access = rights.require_right(reader.db, reader.account, Right.hand_in_together, class_id)
    assignment = editing.find_assignment(reader.db, access.school_class, aid)
    view = _build_own_page(reader, reader.account, access, assignment)
    return render_page(request, "classes/own_team.html", reader.account, page=view)


def _build_own_page(
    reader: Reader, account: Account, access: ClassAccess, assignment: Assignment, problem: str = ""
) -> OwnTeamPage:
    assert access.membership is not None
    db = reader.db
    teams.require_team_assignment(assignment)
    load_student_assignment(db, assignment, account.id, access.membership.groups, utc_now())
    places = team_repository.load_team_places(db, [assignment.id]).get(assignment.id, ())
    partners = list_current_partners(places, account.id)
    students = teams.load_eligible_students(db, assignment)
    proposals = team_repository.load_proposals(db, assignment.id)
    names = {identity: student.name for identity, student in students.items()}
    made = {row.partner_id for row in proposals if row.account_id == account.id} & names.keys()
    received = {row.account_id for row in proposals if row.partner_id == account.id} & names.keys()
    taken = {place.account_id for place in places if place.until is None}
    free = names.keys() - taken - made - {account.id}

    def by_name(chosen: set[UUID]) -> tuple[tuple[UUID, str], ...]:
        return tuple((identity, name) for identity, name in names.items() if identity in chosen)

    former = {share.partner.name for share in list_partnerships(places, account.id) if share.until is not None}
    return OwnTeamPage(
        head=class_head(reader.course, access),
        assignment=assignment,
        href=f"{assignment_href(assignment)}/mon-equipe",
        word=team_word(assignment.team_size),
        partners=partners,
        former=tuple(sorted(former - {partner.name for partner in partners})),
        received=by_name(received),
        made=by_name(made),
        free=by_name(free),
        attempts=_load_shared_attempts(reader, account, access, assignment, places),
        may_choose=assignment.teams_by_students and access.school_class.archived_at is None,
        may_add=len(partners) + 1 < assignment.team_size,
        problem=problem,
    )


def _load_shared_attempts(
    reader: Reader, account: Account, access: ClassAccess, assignment: Assignment, places: Sequence[TeamPlace]
) -> tuple[SharedAttempt, ...]:
    """Return the attempts of partners that make the student's mark today."""
    own = load_visible_marks(reader.db, reader.course, access.school_class, account.id, utc_now())
    names = {place.account_id: place.name for place in places}
    counted = (
        mark.counted.attempt
        for each in own.marks
        if each.assignment.id == assignment.id
        for mark in each.exercises.values()
        if mark.counted is not None
    )
    rows = []
    for attempt_id in counted:
        attempt = gradebook.find_attempt(reader.db, account, attempt_id)
        submission = attempt.submission
        if attempt.shared:
            title = reader.course.title_of_exercise(submission.exercise)
            name = names.get(submission.account_id, "")
            rows.append(SharedAttempt(f"/soumissions/{submission.id}", title, name, submission.created_at))
    return tuple(rows)


@router.post(f"{ASSIGNMENT}/mon-equipe")
def change_own_team(
    request: Request, class_id: str, aid: str, account: SignedIn, reader: CurrentReader, db: Db,
    action: Field = "", eleve: Field = "",
) -> Response:  # fmt: skip
    """Propose, accept, decline, take back a proposal, or leave the team."""
    access = rights.require_right(db, account, Right.hand_in_together, class_id)
    school_class = access.school_class
    assignment = editing.find_assignment(db, school_class, aid, to_change=True)
    try:
        if action == "quitter":
            teams.leave_team(db, school_class, assignment, account.id)
        else:
            other = parse_uuid(eleve, UNKNOWN_STUDENT)
            if action == "proposer":
                teams.propose_teammate(db, school_class, assignment, account.id, other)
            elif action == "accepter":
                teams.accept_proposal(db, school_class, assignment, account.id, other)
            elif action == "refuser":
                teams.delete_proposal(db, assignment, other, account.id)
            elif action == "retirer":
                teams.delete_proposal(db, assignment, account.id, other)
            else:
                raise NotFound(UNKNOWN_ACTION)
    except Conflict as refused:
        roll_back_then_read(db)
        view = _build_own_page(reader, account, access, assignment, refused.detail)
        return render_page(request, "classes/own_team.html", account, status=409, page=view)
    return redirect(f"{assignment_href(assignment)}/mon-equipe")
