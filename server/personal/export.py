"""A person's data as files: an account in JSON, and each attempt as it was sent, with what was found."""

import json
from collections.abc import Collection, Iterator
from dataclasses import asdict
from datetime import datetime
from typing import Any
from uuid import UUID

from sqlalchemy.orm import Session

from graders.core.contract.verdict import Verdict
from server.assignments import feedback, sitting_repository
from server.assignments import repository as assignments
from server.assignments.exemption_service import exemption_effects
from server.assignments.feedback import FeedbackHolds
from server.audit import repository as audit
from server.audit.models import AuditAction, AuditEvent
from server.classes import repository as classes
from server.comments import service as comments
from server.comments.schemas import Conversation
from server.course import Course
from server.database import Database
from server.gradebook import repository as gradings
from server.gradebook import service as gradebook
from server.gradebook.models import Grading
from server.identity import repository as identity
from server.identity.models import Account
from server.marks import repository as marks
from server.marks.models import Override
from server.personal import repository
from server.polls import repository as polls
from server.submissions import repository as submissions
from server.submissions.models import Submission

AT_ONCE = 500
READ_ME = """Vos données sur Balise
======================

compte.json      qui vous êtes ici, vos sessions ouvertes et vos jetons
                 (ni mot de passe ni jeton : ils ne sont pas gardés, seule leur empreinte l’est)
classes.json     vos classes, ce qui y est noté de vous, les aménagements en vigueur pour vous
notes.json       les notes que des enseignants ont modifiées, et ce que les journaux des classes
                 disent de vous, ou de ce que vous y avez changé
exercices.json   vos bilans, vos tirages et, pour un enseignant, les corrigés ouverts
messages.json    ce que vous avez écrit et ce qu’on vous a écrit sur votre travail,
                 et, pour un enseignant, les phrases que vous gardez
controles.json   les contrôles que vous avez commencés, et ce que vous y avez enregistré
essais/          un dossier par envoi : votre réponse telle que vous l’avez envoyée,
                 et corrections.json, ce qui en a été dit à chaque correction

Ce qu’un contrôle retient encore n’y est pas : refaites cette archive une fois ses résultats publiés.
Les dates sont en temps universel, au format ISO 8601. Les figures des verdicts se redessinent
à partir de ce qu’elles montrent ; chacune se télécharge depuis la page de son essai, où l’on revoit
aussi ce que le code a fait.
"""

File = tuple[str, bytes]


def export_files(database: Database, course: Course, account_id: UUID) -> Iterator[File]:
    """Path and content of each; one transaction a file, so that a slow reader holds nothing open.

    What the account sends or erases meanwhile may be in it or not.
    """
    yield "LISEZ-MOI.txt", READ_ME.encode()
    with database.read() as db:
        account = identity.find_account(db, account_id)
        if account is None:
            return
        yield "compte.json", _json(_account(db, account))
        yield "classes.json", _json(_classes(db, account_id))
        yield "notes.json", _json(_marks(db, account_id))
        yield "exercices.json", _json(_exercises(db, account_id))
        yield "messages.json", _json(_messages(db, account_id))
        yield "controles.json", _json(_tests(db, account_id))
    last: UUID | None = None
    while True:
        with database.read() as db:
            names = repository.submission_ids(db, account_id, after=last, most=AT_ONCE)
        for name in names:
            yield from _attempt(database, course, name)
        if len(names) < AT_ONCE:
            return
        last = names[-1]


def _attempt(database: Database, course: Course, name: UUID) -> Iterator[File]:
    with database.read() as db:
        submission = submissions.by_id(db, name)
        if submission is None:
            return
        known = feedback.load_holds(db, submission.account_id, submission.exercise)
        held = known.test_holding(submission.created_at) is not None
        history = [] if held else [_grading(submission, one, known) for one in gradings.list_gradings(db, name)]
    sent = submission.created_at.strftime("%Y-%m-%d-%H%M%S")
    folder = f"essais/{submission.exercise}/{sent}-{str(name)[:8]}"
    exercise = course.exercises.get(submission.exercise)
    ending = "json" if exercise is not None and exercise.answers is not None else "py"
    yield f"{folder}/reponse.{ending}", submission.source
    about: dict[str, Any] = {"id": str(name), "exercise": submission.exercise}
    about |= {"sent_at": _time(submission.created_at)} | ({"held_by_a_test": True} if held else {})
    yield f"{folder}/corrections.json", _json({**about, "seed": submission.seed, "gradings": history})


def _grading(submission: Submission, grading: Grading, known: FeedbackHolds) -> dict[str, Any]:
    return {
        "counts": grading.id == submission.grading_id,
        "started_at": _time(grading.started_at),
        "finished_at": _time(grading.finished_at),
        "verdict": known.redact(Verdict.from_json(grading.verdict)).to_json(),
    }


def _account(db: Session, account: Account) -> dict[str, Any]:
    sessions = identity.load_sessions(db, account.id)
    tokens = identity.load_all_tokens(db, account.id)
    return {
        "id": str(account.id),
        "name": account.name,
        "login": account.login,
        "role": account.role,
        "created_at": _time(account.created_at),
        "sessions": [{"created_at": _time(one.created_at), "expires_at": _time(one.expires_at)} for one in sessions],
        "api_tokens": [
            {
                "label": one.label,
                "created_at": _time(one.created_at),
                "expires_at": _time(one.expires_at),
                "last_used_at": _time(one.last_used_at),
            }
            for one in tokens
        ],
    }


def _exercises(db: Session, account_id: UUID) -> dict[str, Any]:
    sums = gradebook.load_visible_standings(db, account_id)
    unnamed = {name for name, known in feedback.load_all_holds(db, account_id).items() if known.diagnosis is not None}
    return {
        "standings": [
            {
                "exercise": name,
                **{key: _plain(value) for key, value in asdict(one).items() if _told(key, name, unnamed)},
            }
            for name, one in sorted(sums.items())
        ],
        "deals": [
            {"exercise": one.exercise, "seed": one.seed, "created_at": _time(one.created_at)}
            for one in repository.variants_of(db, account_id)
        ],
        "lesson_answers": [
            {
                "question": one.poll,
                "first": one.answer,
                "last": one.last,
                "tries": one.tries,
                "answered_at": _time(one.answered_at),
                "last_at": _time(one.last_at),
            }
            for one in polls.all_of(db, account_id)
        ],
        "solutions_opened": [
            {"exercise": one.exercise, "opened_at": _time(one.opened_at)}
            for one in repository.solution_openings_by(db, account_id)
        ],
        "solutions_opened_to_classes": [
            {"exercise": opening.exercise, "class": name, "opened_at": _time(opening.opened_at)}
            for opening, name in repository.class_openings_by(db, account_id)
        ],
    }


def _told(key: str, exercise: str, unnamed: Collection[str]) -> bool:
    """An assignment may hold diagnoses back."""
    return key != "last_diagnosis" or exercise not in unnamed


def _tests(db: Session, account_id: UUID) -> dict[str, Any]:
    return {
        "sittings": [
            {
                "title": title,
                "began_at": _time(one.began_at),
                "handed_in_at": _time(one.handed_in_at),
                "ended_by": one.ended_by,
            }
            for one, title in sitting_repository.load_account_sittings(db, account_id)
        ],
        "saved": [
            {"exercise": one.exercise, "saved_at": _time(one.saved_at), "text": one.source.decode(errors="replace")}
            for one in sitting_repository.load_all_saved_work(db, account_id)
        ],
    }


def _classes(db: Session, account_id: UUID) -> list[dict[str, Any]]:
    return [
        {
            "class": one.school_class.name,
            "module": one.school_class.module,
            "role": one.membership.role,
            "status": one.membership.status,
            "family_name": one.membership.family_name,
            "given_name": one.membership.given_name,
            "email": one.membership.email,
            "groups": one.membership.groups,
            "joined_at": _time(one.membership.joined_at),
            "left_at": _time(one.membership.left_at),
            "last_seen_at": _time(one.membership.last_seen_at),
            "exemptions": [
                {"assignment": title, **{name: _plain(value) for name, value in exemption_effects(exemption).items()}}
                for title, exemption in assignments.load_student_exemptions(db, account_id, one.school_class.id)
            ],
        }
        for one in classes.load_all_joined_classes(db, account_id)
    ]


def _messages(db: Session, account_id: UUID) -> dict[str, Any]:
    own = comments.load_account_comments(db, account_id)
    return {
        "threads": [_thread(talk) for talk in own.conversations],
        "written_on_work_of_others": [
            {"exercise": exercise, "text": one.text, "at": _time(one.created_at)}
            for one, exercise in own.staff_messages
        ],
        "phrases": [
            {"text": one.text, "exercise": one.exercise, "misconception": one.misconception, "uses": one.uses}
            for one in own.phrases
        ],
        "words_to_you_and_others": [
            {
                "exercise": one.note.exercise,
                "text": one.note.text,
                "link": one.note.link,
                "at": _time(one.note.created_at),
                "seen_at": _time(one.seen_at),
            }
            for one in own.received_notes
        ],
        "words_of_yours": [
            {"exercise": one.exercise, "text": one.text, "link": one.link, "at": _time(one.created_at)}
            for one in own.sent_notes
        ],
    }


def _thread(talk: Conversation) -> dict[str, Any]:
    """Who has answered is not named: their name is their own."""
    thread = talk.thread
    return {
        "exercise": thread.exercise,
        "submission": None if thread.submission_id is None else str(thread.submission_id),
        "lines": None if talk.lines is None else [talk.lines.first, talk.lines.last],
        "check": thread.check_id,
        "state": thread.state,
        "seen_at": _time(thread.seen_at),
        "messages": [
            {
                "by": "staff" if said.message.as_staff else "you",
                "text": said.text,
                "at": _time(said.message.created_at),
            }
            for said in talk.messages
        ],
    }


#: Their reason is for the staff alone: who may read it is asked of the school.
PRIVATE = frozenset({AuditAction.exemption_made, AuditAction.exemption_revoked})
OF_MARKS = frozenset(
    {
        AuditAction.mark_overridden,
        AuditAction.override_withdrawn,
        AuditAction.regrade_applied,
        AuditAction.regrade_undone,
    }
)


def _marks(db: Session, account_id: UUID) -> dict[str, Any]:
    """Events say in words what they are about: while a test holds anything, none is told of any mark from then on."""
    held = gradebook.load_withholding_times(db, account_id)
    since = min(held.values(), default=None)
    about = [
        {**_event(one, name), "reason": _reason(one)}
        for one, name in audit.load_events_about(db, account_id)
        if since is None or one.at < since or one.what not in OF_MARKS
    ]
    by = [{**_event(one, name), "reason": one.reason} for one, name in audit.load_events_by(db, account_id)]
    return {
        "overrides": [
            _override(one, name)
            for one, name in marks.list_overrides_on(db, account_id)
            if one.exercise not in held or one.at < held[one.exercise]
        ],
        "overrides_you_set": [_override(one, name) for one, name in marks.list_overrides_by(db, account_id)],
        "changes_about_you": about,
        "changes_you_made": by,
    }


def _override(one: Override, name: str) -> dict[str, Any]:
    return {
        "class": name,
        "exercise": one.exercise,
        "points": one.points,
        "excused": one.excused,
        "reason": one.reason,
        "at": _time(one.at),
        "withdrawn_at": _time(one.withdrawn_at),
    }


def _event(one: AuditEvent, name: str) -> dict[str, Any]:
    told = {"what": one.what, "about": one.about, "before": one.before, "after": one.after}
    return {"class": name, "at": _time(one.at), **told}


def _reason(one: AuditEvent) -> str:
    return "" if one.what in PRIVATE else one.reason


def _plain(value: Any) -> Any:
    return _time(value) if isinstance(value, datetime) else value


def _time(when: datetime | None) -> str | None:
    return None if when is None else when.isoformat()


def _json(content: Any) -> bytes:
    return json.dumps(content, ensure_ascii=False, indent=2).encode()
