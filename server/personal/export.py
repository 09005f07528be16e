"""A person's data as files: the account in JSON, and each attempt as submitted, with its gradings."""

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
from server.assignments.exemption_service import changed_fields
from server.assignments.feedback import FeedbackHolds
from server.calendars import repository as calendars
from server.classes import repository as classes
from server.comments import service as comments
from server.comments.schemas import Conversation
from server.course import Course
from server.database import Database
from server.federation import personal_rows
from server.gradebook import repository as gradings
from server.gradebook import service as gradebook
from server.gradebook.models import Grading
from server.identity import repository as identity
from server.identity.models import Account
from server.lesson import repository as lessons
from server.personal import erasure_repository, repository
from server.personal.archive_readme import READ_ME
from server.personal.marks_data import format_time, iter_mail_data, marks_data, teams_data
from server.polls import repository as polls
from server.recall import repository as recall
from server.studio import repository as studio
from server.submissions import repository as submissions
from server.submissions.models import Submission

BATCH_SIZE = 500
File = tuple[str, bytes]


def iter_export_files(database: Database, course: Course, account_id: UUID) -> Iterator[File]:
    """Yield path and content of each file; one transaction a file, so that a slow download holds none open.

    Concurrent submissions and deletions may be included or not.
    """
    yield "LISEZ-MOI.txt", READ_ME.encode()
    with database.read() as db:
        account = identity.find_account(db, account_id)
        if account is None:
            return
        yield "compte.json", _encode_json(_load_account_section(db, account))
        yield "classes.json", _encode_json(_classes_data(db, account_id))
        yield "notes.json", _encode_json(marks_data(db, account_id))
        yield "exercices.json", _encode_json(_exercises_data(db, account_id))
        yield "messages.json", _encode_json(_messages_data(db, account_id))
        yield "controles.json", _encode_json(_tests_data(db, account_id))
        yield "mes_exercices.json", _encode_json(_authored_exercises_data(db, account_id))
    last: UUID | None = None
    while True:
        with database.read() as db:
            names = repository.load_submission_ids_page(db, account_id, after=last, limit=BATCH_SIZE)
        for name in names:
            yield from _iter_attempt_files(database, course, name)
        if len(names) < BATCH_SIZE:
            return
        last = names[-1]


def _authored_exercises_data(db: Session, account_id: UUID) -> list[dict[str, Any]]:
    """Return the exercises that an account has written, as typed."""
    return [
        {"exercise": exercise.name, "module": exercise.module, "draft": exercise.draft, "versions": exercise.number}
        | ({"tryout": exercise.tryout} if exercise.tryout else {})
        for exercise in studio.list_exercises(db, account_id)
    ]


def _iter_attempt_files(database: Database, course: Course, name: UUID) -> Iterator[File]:
    with database.read() as db:
        submission = submissions.find_submission(db, name)
        if submission is None:
            return
        feedback_rules = feedback.load_holds(db, submission.account_id, submission.exercise)
        held = feedback_rules.find_withholding_test(submission.created_at) is not None
        history = (
            []
            if held
            else [_grading_data(submission, grading, feedback_rules) for grading in gradings.list_gradings(db, name)]
        )
    sent = submission.created_at.strftime("%Y-%m-%d-%H%M%S")
    folder = f"essais/{submission.exercise}/{sent}-{str(name)[:8]}"
    exercise = course.exercises.get(submission.exercise)
    ending = "json" if exercise is not None and exercise.answers is not None else "py"
    yield f"{folder}/reponse.{ending}", submission.source
    about: dict[str, Any] = {"id": str(name), "exercise": submission.exercise}
    about |= {"sent_at": format_time(submission.created_at)} | ({"held_by_a_test": True} if held else {})
    yield f"{folder}/corrections.json", _encode_json({**about, "seed": submission.seed, "gradings": history})


def _grading_data(submission: Submission, grading: Grading, feedback_rules: FeedbackHolds) -> dict[str, Any]:
    return {
        "counts": grading.id == submission.grading_id,
        "started_at": format_time(grading.started_at),
        "finished_at": format_time(grading.finished_at),
        "verdict": feedback_rules.remove_withheld_parts(Verdict.from_json(grading.verdict)).to_json(),
    }


def _load_account_section(db: Session, account: Account) -> dict[str, Any]:
    sessions = identity.load_sessions(db, account.id)
    tokens = identity.load_all_tokens(db, account.id)
    calendar = calendars.find_calendar_address(db, account.id)
    return {
        "id": str(account.id),
        "name": account.name,
        "login": account.login,
        "role": account.role,
        "created_at": format_time(account.created_at),
        "erasure_requests": [
            {"requested_at": format_time(request.requested_at), "by_staff": request.by_staff}
            for request in erasure_repository.load_erasure_requests_of_account(db, account.id)
        ],
        "known_browsers": [
            {"seen_at": format_time(device.seen_at)} for device in identity.load_devices(db, account.id)
        ],
        "calendar_address": None if calendar is None else {"created_at": format_time(calendar.created_at)},
        "mails": list(iter_mail_data(db, account.id)),
        "has_pseudonym": account.has_pseudonym,
        "identities": [
            {
                "issuer": known.issuer,
                "subject": known.subject,
                "created_at": format_time(known.created_at),
                "seen_at": format_time(known.seen_at),
            }
            for known in identity.load_identities(db, account.id)
        ],
        "courses_on_platforms": [
            {"course": title, "seen_at": format_time(course.seen_at)}
            for course, title in personal_rows.load_courses_taught(db, account.id)
        ],
        "classes_of_the_school": [
            {"class": title, "seen_at": format_time(waiting.seen_at)}
            for waiting, title in personal_rows.load_awaited_contexts(db, account.id)
        ],
        "marks_sent_to_platforms": [
            {"assignment": title, "points": mark.sent_points, "sent_at": format_time(mark.sent_at)}
            for mark, title in personal_rows.load_sent_marks(db, account.id)
        ],
        "sessions": [
            {"created_at": format_time(session.created_at), "expires_at": format_time(session.expires_at)}
            for session in sessions
        ],
        "api_tokens": [
            {
                "label": token.label,
                "created_at": format_time(token.created_at),
                "expires_at": format_time(token.expires_at),
                "last_used_at": format_time(token.last_used_at),
            }
            for token in tokens
        ],
    }


def _exercises_data(db: Session, account_id: UUID) -> dict[str, Any]:
    sums = gradebook.load_visible_standings(db, account_id)
    hidden_diagnoses = {
        name
        for name, feedback_rules in feedback.load_holds_by_exercise(db, account_id).items()
        if feedback_rules.diagnosis is not None
    }
    return {
        "standings": [
            {
                "exercise": name,
                **{
                    key: _json_value(value)
                    for key, value in asdict(standing).items()
                    if _is_visible_column(key, name, hidden_diagnoses)
                },
            }
            for name, standing in sorted(sums.items())
        ],
        "deals": [
            {"exercise": variant.exercise, "seed": variant.seed, "created_at": format_time(variant.created_at)}
            for variant in repository.load_variants(db, account_id)
        ],
        "lesson_answers": [
            {
                "question": poll_answer.poll,
                "first": poll_answer.answer,
                "last": poll_answer.last,
                "tries": poll_answer.tries,
                "answered_at": format_time(poll_answer.answered_at),
                "last_at": format_time(poll_answer.last_at),
            }
            for poll_answer in polls.load_poll_answers(db, account_id)
        ],
        "recall_answers": [
            {
                "subject": answer.subject,
                "question": answer.kind,
                "exercise": answer.exercise,
                "misconception": answer.misconception,
                "right": answer.is_right,
                "answered_at": format_time(answer.answered_at),
            }
            for answer in recall.load_recall_answers(db, account_id)
        ],
        "choices": dict(recall.load_choices(db, account_id)),
        "seen_in_lessons": [
            {"class": name, "exercise": visit.exercise, "at": format_time(visit.visited_at)}
            for visit, name in lessons.load_account_visits(db, account_id)
        ],
        "lessons_started": [
            {"class": name, "exercises": lesson.exercises, "at": format_time(lesson.started_at)}
            for lesson, name in lessons.load_lessons_started_by(db, account_id)
        ],
        "solutions_opened": [
            {"exercise": opening.exercise, "opened_at": format_time(opening.opened_at)}
            for opening in repository.load_solution_openings_by(db, account_id)
        ],
        "solutions_opened_to_classes": [
            {"exercise": opening.exercise, "class": name, "opened_at": format_time(opening.opened_at)}
            for opening, name in repository.load_class_openings_by(db, account_id)
        ],
    }


def _is_visible_column(key: str, exercise: str, hidden_diagnoses: Collection[str]) -> bool:
    """An assignment may hold diagnoses back."""
    return key != "last_diagnosis" or exercise not in hidden_diagnoses


def _tests_data(db: Session, account_id: UUID) -> dict[str, Any]:
    return {
        "sittings": [
            {
                "title": title,
                "began_at": format_time(sitting.began_at),
                "handed_in_at": format_time(sitting.handed_in_at),
                "ended_by": sitting.ended_by,
            }
            for sitting, title in sitting_repository.load_account_sittings(db, account_id)
        ],
        **teams_data(db, account_id),
        "saved": [
            {
                "exercise": work.exercise,
                "saved_at": format_time(work.saved_at),
                "text": work.source.decode(errors="replace"),
            }
            for work in sitting_repository.load_all_saved_work(db, account_id)
        ],
    }


def _classes_data(db: Session, account_id: UUID) -> list[dict[str, Any]]:
    return [
        {
            "class": joined_class.school_class.name,
            "module": joined_class.school_class.module,
            "role": joined_class.membership.role,
            "status": joined_class.membership.status,
            "family_name": joined_class.membership.family_name,
            "given_name": joined_class.membership.given_name,
            "email": joined_class.membership.email,
            "groups": joined_class.membership.groups,
            "joined_at": format_time(joined_class.membership.joined_at),
            "left_at": format_time(joined_class.membership.left_at),
            "last_seen_at": format_time(joined_class.membership.last_seen_at),
            "exemptions": [
                {"assignment": title, **{name: _json_value(value) for name, value in changed_fields(exemption).items()}}
                for title, exemption in assignments.load_student_exemptions(
                    db, account_id, joined_class.school_class.id
                )
            ],
        }
        for joined_class in classes.load_all_joined_classes(db, account_id)
    ]


def _messages_data(db: Session, account_id: UUID) -> dict[str, Any]:
    own = comments.load_account_comments(db, account_id)
    return {
        "threads": [_thread_data(talk, own.seen.get(talk.thread.id)) for talk in own.conversations],
        "read_on_shared_work": [{"exercise": name, "seen_at": format_time(at)} for name, at in own.shared_readings],
        "written_on_work_of_others": [
            {"exercise": exercise, "text": message.text, "at": format_time(message.created_at)}
            for message, exercise in own.staff_messages
        ],
        "phrases": [
            {
                "text": phrase.text,
                "exercise": phrase.exercise,
                "misconception": phrase.misconception,
                "uses": phrase.uses,
            }
            for phrase in own.phrases
        ],
        "words_to_you_and_others": [
            {
                "exercise": note_copy.note.exercise,
                "text": note_copy.note.text,
                "link": note_copy.note.link,
                "at": format_time(note_copy.note.created_at),
                "seen_at": format_time(note_copy.seen_at),
            }
            for note_copy in own.received_notes
        ],
        "words_of_yours": [
            {"exercise": note.exercise, "text": note.text, "link": note.link, "at": format_time(note.created_at)}
            for note in own.sent_notes
        ],
    }


def _thread_data(talk: Conversation, seen_at: datetime | None) -> dict[str, Any]:
    """Convert a thread; authors of answers are not named: their names are their own data."""
    thread = talk.thread
    return {
        "exercise": thread.exercise,
        "submission": None if thread.submission_id is None else str(thread.submission_id),
        "lines": None if talk.lines is None else [talk.lines.first, talk.lines.last],
        "check": thread.check_id,
        "state": thread.state,
        "seen_at": format_time(seen_at),
        "messages": [
            {
                "by": "staff" if said.message.as_staff else "you",
                "text": said.text,
                "at": format_time(said.message.created_at),
            }
            for said in talk.messages
        ],
    }


def _json_value(value: Any) -> Any:
    return format_time(value) if isinstance(value, datetime) else value


def _encode_json(content: Any) -> bytes:
    return json.dumps(content, ensure_ascii=False, indent=2).encode()
