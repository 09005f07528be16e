"""Form and end the teams of an assignment, by its teachers, or by students who agree.

Every function works inside the caller's transaction, on an assignment whose class is locked
(`editing.find_assignment(..., to_change=True)`).
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Mapping, Sequence
from datetime import datetime
from random import Random
from uuid import UUID, uuid4

from sqlalchemy.orm import Session

from server.assignments import repository, team_repository
from server.assignments.models import Assignment, TeamMember, TeamProposal
from server.assignments.rules import is_assigned_to
from server.assignments.stages import AssignmentStage, assignment_stage
from server.assignments.team_rules import team_rules_in_force, team_word
from server.audit import service as audit
from server.audit.models import AuditAction
from server.base.errors import Conflict, Invalid, NotFound, WrongMoment
from server.classes import repository as classes
from server.classes.models import SchoolClass
from server.classes.schemas import Member
from server.classes.service import require_not_archived
from server.database import utc_now

NOT_BY_TEAMS = "Ce devoir se rend seul. Votre enseignant peut le déclarer « en binôme »."
BY_TEACHER = "C’est votre enseignant qui forme les {word}s de ce devoir : demandez-lui."
NO_CLASSMATE = "Cette personne n’est pas un élève à qui ce devoir est donné."
ALREADY = "{name} a déjà un {word} pour ce devoir : défaites-le d’abord."
TOO_MANY = "Ce devoir se rend à {size} au plus : {names}."
ALONE = "Il faut au moins deux élèves : {names}."
FULL = "Vous êtes déjà {size}, le plus que ce devoir permette."
OVER = "Ce devoir est fermé : les {word}s n’y changent plus. Votre enseignant peut encore le faire."
NO_PROPOSAL = "Cette proposition n’existe plus : rechargez la page."
NO_TEAM = "Ce {word} n’existe plus : rechargez la page."
MANY_PROPOSALS = "Vous avez déjà proposé à {count} élèves : retirez d’abord une proposition."
MAX_PROPOSALS = 10


def require_team_assignment(assignment: Assignment) -> None:
    """Raise NotFound for an assignment that everybody hands in alone."""
    if assignment.team_size < 2:
        raise NotFound(NOT_BY_TEAMS)


def load_eligible_students(db: Session, assignment: Assignment) -> Mapping[UUID, Member]:
    """Return the active students to whom the assignment is given."""
    return {
        member.id: member
        for member in classes.load_members(db, assignment.class_id)
        if member.is_active_student and is_assigned_to(assignment, member.groups)
    }


def load_largest_team_size(db: Session, assignment_id: UUID) -> int:
    """Return the most students that ever were in one team of an assignment; 0 without any."""
    members = defaultdict(set)
    for place in team_repository.load_team_places(db, [assignment_id]).get(assignment_id, ()):
        members[place.team_id].add(place.account_id)
    return max(map(len, members.values()), default=0)


def form_teams(
    db: Session,
    school_class: SchoolClass,
    by: UUID,
    assignment: Assignment,
    teams: Sequence[Sequence[UUID]],
    *,
    earlier: bool = False,
) -> None:
    """Form teams of students who have none. `earlier`: the attempts that they have sent since the opening count for all
    of them too. Raise Invalid, NotFound or Conflict; then nothing is formed."""
    require_not_archived(school_class)
    require_team_assignment(assignment)
    students = load_eligible_students(db, assignment)
    taken = {member.account_id for member in team_repository.load_current_members(db, assignment.id)}
    now = utc_now()
    since = min(assignment.opens_at, now) if earlier else now
    for team in teams:
        unique = tuple(dict.fromkeys(team))
        if any(student not in students for student in unique):
            raise NotFound(NO_CLASSMATE)
        names = ", ".join(students[student].name for student in unique)
        if len(unique) < 2:
            raise Invalid(ALONE.format(names=names))
        if len(unique) > assignment.team_size:
            raise Invalid(TOO_MANY.format(size=assignment.team_size, names=names))
        for student in unique:
            if student in taken:
                raise Conflict(ALREADY.format(name=students[student].name, word=team_word(assignment.team_size)))
            taken.add(student)
        _add_members(db, school_class, by, assignment, uuid4(), unique, since)


def _add_members(
    db: Session,
    school_class: SchoolClass,
    by: UUID,
    assignment: Assignment,
    team_id: UUID,
    students: Collection[UUID],
    since: datetime,
) -> None:
    for student in students:
        db.add(TeamMember(assignment_id=assignment.id, team_id=team_id, account_id=student, since=since))
        _record_team_event(db, school_class, by, assignment, AuditAction.team_formed, student, team_id)
    team_repository.delete_proposals(db, assignment.id, students)
    db.flush()


def form_random_teams(db: Session, school_class: SchoolClass, by: UUID, assignment: Assignment, random: Random) -> int:
    """Put at random the students without a team into teams of the assignment's size; return how many were formed.

    A last one who would stay alone joins nobody: the teacher decides.
    """
    taken = {member.account_id for member in team_repository.load_current_members(db, assignment.id)}
    free = sorted(student for student in load_eligible_students(db, assignment) if student not in taken)
    random.shuffle(free)
    size = assignment.team_size
    teams = [free[start : start + size] for start in range(0, len(free), size)]
    whole = [team for team in teams if len(team) > 1]
    form_teams(db, school_class, by, assignment, whole)
    return len(whole)


def end_team(db: Session, school_class: SchoolClass, by: UUID, assignment: Assignment, team_id: UUID) -> None:
    """End a team: from now on each hands in alone. Raise NotFound."""
    require_not_archived(school_class)
    members = [row for row in team_repository.load_current_members(db, assignment.id) if row.team_id == team_id]
    if not members:
        raise NotFound(NO_TEAM.format(word=team_word(assignment.team_size)))
    _end_memberships(db, school_class, by, assignment, members)


def _end_memberships(
    db: Session, school_class: SchoolClass, by: UUID, assignment: Assignment, members: Collection[TeamMember]
) -> None:
    for member in members:
        member.until = max(utc_now(), member.since)
        _record_team_event(db, school_class, by, assignment, AuditAction.team_ended, member.account_id, member.team_id)
    db.flush()


def _record_team_event(
    db: Session,
    school_class: SchoolClass,
    by: UUID,
    assignment: Assignment,
    what: AuditAction,
    student: UUID,
    team_id: UUID,
) -> None:
    values = {"team": team_id.hex[:6]}
    before, after = (values, None) if what is AuditAction.team_ended else (None, values)
    audit.record_event(
        db, school_class.id, by, what, student=student, about=assignment.title, before=before, after=after
    )


def _require_student_may_form_team(
    db: Session, school_class: SchoolClass, assignment: Assignment, student: UUID
) -> None:
    require_not_archived(school_class)
    require_team_assignment(assignment)
    word = team_word(assignment.team_size)
    own = load_eligible_students(db, assignment).get(student)
    if own is None:
        raise NotFound(NO_CLASSMATE)
    if not assignment.teams_by_students:
        raise Conflict(BY_TEACHER.format(word=word))
    exemptions = repository.load_exemptions(db, [assignment.id]).get(assignment.id, ())
    places = team_repository.load_team_places(db, [assignment.id]).get(assignment.id, ())
    rules = team_rules_in_force(assignment, exemptions, student, own.groups, places)
    if assignment_stage(rules, utc_now()) is AssignmentStage.closed:
        raise WrongMoment(OVER.format(word=word))


def propose_teammate(
    db: Session, school_class: SchoolClass, assignment: Assignment, student: UUID, partner: UUID
) -> None:
    """Propose to a classmate to hand in together; if they have proposed the same, form the team at once.

    Raise NotFound, Conflict or WrongMoment.
    """
    _require_student_may_form_team(db, school_class, assignment, student)
    if partner == student or partner not in load_eligible_students(db, assignment):
        raise NotFound(NO_CLASSMATE)
    proposals = team_repository.load_proposals(db, assignment.id)
    if any((row.account_id, row.partner_id) == (partner, student) for row in proposals):
        accept_proposal(db, school_class, assignment, student, partner)
        return
    own = [row for row in proposals if row.account_id == student]
    if any(row.partner_id == partner for row in own):
        return
    if len(own) >= MAX_PROPOSALS:
        raise Conflict(MANY_PROPOSALS.format(count=MAX_PROPOSALS))
    _require_free_place(db, assignment, student)
    db.add(TeamProposal(assignment_id=assignment.id, account_id=student, partner_id=partner))
    db.flush()


def _require_free_place(db: Session, assignment: Assignment, student: UUID) -> tuple[UUID | None, int]:
    """Return the team of a student, None without one, and how many it has. Raise Conflict for a full one."""
    current = team_repository.load_current_members(db, assignment.id)
    team_id = next((row.team_id for row in current if row.account_id == student), None)
    count = sum(row.team_id == team_id for row in current) if team_id else 1
    if count >= assignment.team_size:
        raise Conflict(FULL.format(size=assignment.team_size))
    return team_id, count


def accept_proposal(
    db: Session, school_class: SchoolClass, assignment: Assignment, student: UUID, proposer: UUID
) -> None:
    """Accept a classmate's proposal: the student joins their team, or a new one. Raise NotFound, Conflict or
    WrongMoment."""
    _require_student_may_form_team(db, school_class, assignment, student)
    students = load_eligible_students(db, assignment)
    proposals = team_repository.load_proposals(db, assignment.id)
    if not any((row.account_id, row.partner_id) == (proposer, student) for row in proposals):
        raise NotFound(NO_PROPOSAL)
    if proposer not in students:
        raise NotFound(NO_CLASSMATE)
    taken = {row.account_id: row.team_id for row in team_repository.load_current_members(db, assignment.id)}
    if student in taken:
        word = team_word(assignment.team_size)
        raise Conflict(ALREADY.format(name=students[student].name, word=word))
    team_id, _ = _require_free_place(db, assignment, proposer)
    if team_id is None:
        form_teams(db, school_class, student, assignment, [(proposer, student)])
    else:
        _add_members(db, school_class, student, assignment, team_id, [student], utc_now())


def delete_proposal(db: Session, assignment: Assignment, proposer: UUID, partner: UUID) -> None:
    """Take back, or decline, a proposal; one that is gone already changes nothing."""
    for row in team_repository.load_proposals(db, assignment.id):
        if (row.account_id, row.partner_id) == (proposer, partner):
            db.delete(row)
    db.flush()


def leave_team(db: Session, school_class: SchoolClass, assignment: Assignment, student: UUID) -> None:
    """Take a student out of their team; who would remain alone is out too. Raise NotFound, Conflict or WrongMoment."""
    _require_student_may_form_team(db, school_class, assignment, student)
    current = team_repository.load_current_members(db, assignment.id)
    team_id = next((row.team_id for row in current if row.account_id == student), None)
    if team_id is None:
        raise NotFound(NO_TEAM.format(word=team_word(assignment.team_size)))
    team = [row for row in current if row.team_id == team_id]
    leaving = team if len(team) == 2 else [row for row in team if row.account_id == student]
    _end_memberships(db, school_class, student, assignment, leaving)
