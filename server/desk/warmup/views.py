"""From the questions of a class on one day to their pages."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from sqlalchemy.orm import Session

from server.board.relapses import FEWEST_CASES
from server.classes.models import SchoolClass
from server.course import Course
from server.desk.views import class_head, class_href
from server.identity.models import Account
from server.polls import repository as polls
from server.rights.models import Right
from server.rights.service import ClassAccess
from server.warmup import service

PATH = "/pour-commencer"


def warm_up_href(school_class: SchoolClass) -> str:
    return f"{class_href(school_class)}{PATH}"


def staff_page(
    db: Session, course: Course, access: ClassAccess, problem: str = "", *, counts_relapses: bool = False
) -> Mapping[str, Any]:
    """Build the page of who teaches: today's questions with the answers of the class, or what prepares them.

    With `counts_relapses`, whether they serve, which takes all attempts of the class.
    """
    school_class = access.school_class
    warm_up = service.find_todays_warm_up(db, school_class.id)
    return {
        "head": class_head(course, access, "/seance"),
        "href": warm_up_href(school_class),
        "questions": [] if warm_up is None else service.count_answers(db, school_class, warm_up),
        "students": polls.count_active_students(db, school_class.id),
        "may_prepare": access.has(Right.run_lessons) and school_class.archived_at is None,
        "stream": f"{warm_up_href(school_class)}/evenements",
        "relapses": service.load_relapse_stats(db, course, school_class) if counts_relapses else None,
        "fewest": FEWEST_CASES,
        "problem": problem,
    }


def student_page(
    db: Session, course: Course, access: ClassAccess, account: Account, problem: str = ""
) -> Mapping[str, Any]:
    """Build the page of a student: today's questions, each with its mark once it is answered."""
    warm_up = service.find_todays_warm_up(db, access.school_class.id)
    questions = [] if warm_up is None else service.parse_stored_questions(warm_up)
    said = {} if warm_up is None else service.load_own_answers(db, account.id, access.school_class, warm_up)
    return {
        "head": class_head(course, access),
        "href": warm_up_href(access.school_class),
        "rows": [
            {"question": question, "said": question.find_option(said.get(number, ""))}
            for number, question in enumerate(questions)
        ],
        "problem": problem,
    }


def wall_page(db: Session, access: ClassAccess, number: int, *, shows_answers: bool) -> Mapping[str, Any] | None:
    """Build a question for the projector, with numbers of students alone; None where there is no such question."""
    school_class = access.school_class
    warm_up = service.find_todays_warm_up(db, school_class.id)
    counted = [] if warm_up is None else service.count_answers(db, school_class, warm_up)
    if not 0 <= number < len(counted):
        return None
    href = warm_up_href(school_class)
    return {
        "href": href,
        "stream": f"{href}/evenements?mur=oui&question={number + 1}{'&reponses=oui' if shows_answers else ''}",
        "class_href": class_href(school_class),
        "row": counted[number],
        "number": number,
        "total": len(counted),
        "students": polls.count_active_students(db, school_class.id),
        "shows_answers": shows_answers,
    }
