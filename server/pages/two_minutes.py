"""« Deux minutes »: a few questions about what one confused, when they are due."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from datetime import date
from typing import Annotated, Any, Literal

from fastapi import APIRouter, Form, Request
from fastapi.responses import Response
from starlette.concurrency import run_in_threadpool

from graders.core.answers.numbers import MAX_LENGTH
from server.base.errors import Invalid
from server.base.http import client_address
from server.course import Course
from server.course.dependencies import CourseOf
from server.database import Database
from server.database.dependencies import DatabaseOf
from server.gradebook import service as gradebook
from server.hunts.dependencies import HuntsOf
from server.hunts.protocol import HuntName, OfferedHunt
from server.hunts.service import (
    MAX_ARGUMENTS,
    HuntService,
    choose_question_kind,
    hunt_names_of_misconceptions,
    may_ask_about_mistakes_again,
)
from server.identity.dependencies import OptionalAccount, SignedIn
from server.identity.models import Account
from server.pages.hunts import MAX_NAME, WORDS, Act, Kind, Typed, build_hunt_page, judge_hunt_answer
from server.polls.models import POLL_LENGTH
from server.recall import calculations, repository, retrievals
from server.recall.calculations import AskedCalculation
from server.recall.retrievals import AskedRetrieval
from server.recall.scheduling import SITTING_QUESTIONS
from server.recall.service import OFF, REMINDERS, RecallCandidate, RecallState, load_account_recall_state
from server.web.forms import redirect, redirect_to_login
from server.web.rendering import render_page
from server.web.views import exercise_href, find_exercise, find_module

router = APIRouter(include_in_schema=False)

PATH = "/deux-minutes"


def load_recall_state(database: Database, course: CourseOf, account: Account) -> RecallState:
    """Load what comes back to an account, in a transaction of its own."""
    with database.read() as db:
        progress = gradebook.load_progress(db, account)
        solved = {name for name, own in progress.items() if own.succeeded}
        choices = repository.load_choices(db, account.id)
        return load_account_recall_state(
            db, course, account.id, solved, lambda exercise: may_ask_about_mistakes_again(course, exercise), choices
        )


@router.get(PATH)
async def show_due_question(
    request: Request, account: OptionalAccount, database: DatabaseOf, course: CourseOf, hunts: HuntsOf
) -> Response:
    """Ask about the most forgotten of what is due."""
    if account is None:
        return redirect_to_login(request)
    recall = await run_in_threadpool(load_recall_state, database, course, account)
    page: dict[str, Any] = {"offer": None}
    for subject, candidates in recall.due.items():
        if found := retrievals.find_retrieval_of_subject(course, subject):
            asked = await run_in_threadpool(retrievals.draw_retrieval, *found, account, retrievals.today_at_school())
            page = _build_question_page(course, asked)
            break
        turn = recall.answers.get(subject, 0)
        if chosen := _choose_calculation(course, candidates, turn):
            calculation = await run_in_threadpool(
                calculations.draw_calculation,
                course,
                chosen.exercise,
                chosen.misconception,
                account,
                retrievals.today_at_school(),
            )
            page = await run_in_threadpool(_build_calculation_page, calculation)
            break
        offer, question = await _offer_hunt(hunts, account, turn, candidates, client_address(request))
        if offer is not None:
            exercise = course.exercises[offer.hunt.exercise]
            page = dict(await run_in_threadpool(build_hunt_page, course, exercise, offer, question))
            break
    return await run_in_threadpool(_render_recall_page, request, account, page, recall)


def _rotate_candidates(candidates: Sequence[RecallCandidate], turn: int) -> Sequence[RecallCandidate]:
    """Return the candidates from that of a turn on, the others after them."""
    place = turn % max(1, len(candidates))
    return [*candidates[place:], *candidates[:place]]


def _choose_calculation(course: Course, candidates: Sequence[RecallCandidate], turn: int) -> RecallCandidate | None:
    """Return the candidate of a turn where it is one of a calculation, or the first such where none has a program."""
    ordered = _rotate_candidates(candidates, turn)
    answered = [candidate for candidate in ordered if course.exercises[candidate.exercise].answers is not None]
    return answered[0] if answered and (answered[0] == ordered[0] or len(answered) == len(ordered)) else None


async def _offer_hunt(
    hunts: HuntService, account: Account, turn: int, candidates: Sequence[RecallCandidate], address: str
) -> tuple[OfferedHunt | None, Kind]:
    """Offer the first misconception about which a question can be asked: a hunt, a prediction and a line in turn."""
    offer = await hunts.offer_first_possible_hunt(
        account, hunt_names_of_misconceptions(_rotate_candidates(candidates, turn)), address
    )
    return offer, "entree" if offer is None else WORDS[choose_question_kind(offer, turn)]


@router.post(f"{PATH}/questions/{{module:module}}")
def answer_lesson_question(
    request: Request,
    account: SignedIn,
    database: DatabaseOf,
    course: CourseOf,
    module: str,
    question: Annotated[str, Form(max_length=POLL_LENGTH)],
    jour: Annotated[date, Form()],
    reponse: Annotated[str, Form(max_length=MAX_LENGTH)] = "",
) -> Response:
    """Mark an answer to a retrieval question as in its lesson."""
    course_module = find_module(course, module)
    asked = retrievals.draw_retrieval(course_module, question, account, jour)
    shown: dict[str, Any] = {"typed": reponse}
    try:
        with database.write() as db:
            shown["marking"] = retrievals.submit_retrieval(db, course_module, question, account, jour, reponse)
    except Invalid as error:
        shown["refusal"] = str(error)
    return _render_recall_page(
        request, account, _build_question_page(course, asked) | shown, load_recall_state(database, course, account)
    )


@router.post(f"{PATH}/calculs")
def answer_calculation(
    request: Request,
    account: SignedIn,
    database: DatabaseOf,
    course: CourseOf,
    exercice: Annotated[str, Form(max_length=MAX_NAME)],
    erreur: Annotated[str, Form(max_length=MAX_NAME)],
    jour: Annotated[date, Form()],
    valeur: Annotated[list[Annotated[str, Form(max_length=MAX_LENGTH)]], Form(max_length=MAX_ARGUMENTS)] = [],  # noqa: B006 (read by FastAPI)
) -> Response:
    """Mark an answer to a small calculation or a choice."""
    asked = calculations.draw_calculation(course, exercice, erreur, account, jour)
    shown: dict[str, Any] = {"typed": valeur}
    try:
        with database.write() as db:
            marked = calculations.submit_calculation(db, course, account, asked, valeur)
        shown["marked"] = {
            "is_right": marked.is_right, "why": asked.exercise.render_paragraphs(marked.message), "right": marked.right
        }  # fmt: skip
    except Invalid as error:
        shown["refusal"] = str(error)
    return _render_recall_page(
        request, account, _build_calculation_page(asked) | shown, load_recall_state(database, course, account)
    )


@router.post(PATH)
async def answer_due_hunt(
    request: Request,
    account: SignedIn,
    database: DatabaseOf,
    course: CourseOf,
    hunts: HuntsOf,
    exercice: Annotated[str, Form(max_length=MAX_NAME)],
    erreur: Annotated[str, Form(max_length=MAX_NAME)],
    fonction: Annotated[str, Form(max_length=MAX_NAME)],
    question: Annotated[Kind, Form()] = "entree",
    action: Annotated[Act, Form()] = "essayer",
    valeur: Typed = [],  # noqa: B006 (read by FastAPI, and never changed)
) -> Response:
    """Judge an answer as on the page of hunts."""
    exercise, address = find_exercise(course, *_split_exercise_id(exercice)), client_address(request)
    hunt = HuntName(exercise=exercise.id, misconception=erreur, function=fonction)
    offer = await hunts.offer_hunt_again(account, hunt, address)
    outcome = None
    if offer is not None:
        outcome = await judge_hunt_answer(hunts, account, offer, question, action, valeur, address)
    recall = await run_in_threadpool(load_recall_state, database, course, account)
    page = await run_in_threadpool(
        build_hunt_page, course, exercise, offer, question, valeur, outcome, gave_up=action == "abandonner"
    )
    return await run_in_threadpool(_render_recall_page, request, account, dict(page), recall)


@router.post(f"{PATH}/rappels")
def set_reminders(
    account: SignedIn, database: DatabaseOf, rappels: Annotated[Literal["oui", "non"], Form()]
) -> Response:
    """Propose questions on the home page, or no more."""
    with database.write() as db:
        repository.save_choice(db, account.id, REMINDERS, OFF if rappels == "non" else "")
    return redirect("/" if rappels == "non" else PATH)


def _build_question_page(course: Course, asked: AskedRetrieval) -> dict[str, Any]:
    module, slug = course.modules[asked.module], asked.name.partition("/")[0]
    title = next((lesson.title for lesson in module.lessons if lesson.slug == slug), module.title)
    return {"offer": None, "asked": asked, "lesson": title, "typed": "", "refusal": "", "marking": None}


def _build_calculation_page(asked: AskedCalculation) -> dict[str, Any]:
    exercise, question = asked.exercise, asked.question
    return {
        "offer": None,
        "calculation": asked,
        "exercise_title": exercise.title,
        "exercise_href": exercise_href(exercise),
        "text": exercise.render_paragraphs(question.text),
        "pieces": [(piece.id, exercise.render_line(piece.text)) for piece in question.pieces],
        "given": [
            (exercise.render_line(f"${datum.symbol}$"), datum.text, datum.unit, datum.name) for datum in asked.given
        ],
        "typed": (),
        "refusal": "",
        "marked": None,
    }


def _split_exercise_id(exercise: str) -> Sequence[str]:
    module, _, slug = exercise.partition("/")
    return module, slug


def _render_recall_page(request: Request, account: Account, page: Mapping[str, Any], recall: RecallState) -> Response:
    shown = {"asked": None, "calculation": None, **page, "recall": recall, "here": PATH, "sitting": SITTING_QUESTIONS}
    return render_page(request, "two_minutes.html", account, page=shown)
