"""The pages of bug hunts: a wrong program, and an input that shows its mistake, or what it answers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Literal

from fastapi import APIRouter, Form, Query, Request
from fastapi.responses import Response
from starlette.concurrency import run_in_threadpool

from server.base.http import client_address
from server.board.catalogue import find_misconception
from server.course import Course, Exercise
from server.course.dependencies import CourseOf
from server.course.families import find_family
from server.hunts.dependencies import HuntsOf
from server.hunts.protocol import HuntName, HuntTrialOutcome, OfferedHunt
from server.hunts.service import MAX_ARGUMENTS, MAX_TYPED_CHARACTERS, HuntService
from server.identity.dependencies import OptionalAccount, SignedIn
from server.recall.models import QuestionKind
from server.text.python_colours import colour_python_lines
from server.web.forms import redirect_to_login
from server.web.rendering import render_page
from server.web.views import build_module_link, exercise_href, find_exercise

router = APIRouter(include_in_schema=False)

MAX_SKIP = 500
MAX_NAME = 100
#: Digits of the number of a line.
MAX_DIGITS = 4
Skip = Annotated[int, Query(alias="suite", ge=0, le=MAX_SKIP)]
Kind = Literal["entree", "prevision", "ligne"]
Act = Literal["essayer", "abandonner"]
Typed = Annotated[list[Annotated[str, Form(max_length=MAX_TYPED_CHARACTERS)]], Form(max_length=MAX_ARGUMENTS)]
KINDS: Mapping[Kind, QuestionKind] = {
    "entree": QuestionKind.hunt,
    "prevision": QuestionKind.prediction,
    "ligne": QuestionKind.line,
}
WORDS: Mapping[QuestionKind, Kind] = {kind: word for word, kind in KINDS.items()}


def hunt_href(exercise: Exercise) -> str:
    return f"{exercise_href(exercise)}/chasse"


@router.get("/{module:module}/exercices/{slug}/chasse")
async def show_hunt(
    request: Request,
    module: str,
    slug: str,
    account: OptionalAccount,
    course: CourseOf,
    hunts: HuntsOf,
    skip: Skip = 0,
    question: Annotated[Kind, Query()] = "entree",
) -> Response:
    exercise = find_exercise(course, module, slug)
    if account is None:
        return redirect_to_login(request)
    offer = await hunts.offer_hunt(account, exercise.id, skip, client_address(request))
    page = build_hunt_page(
        course, exercise, offer, "entree" if offer is None else choose_possible_question(offer, question)
    )
    return await run_in_threadpool(render_page, request, "hunt.html", account, page=page)


@router.post("/{module:module}/exercices/{slug}/chasse")
async def answer_hunt(
    request: Request,
    module: str,
    slug: str,
    account: SignedIn,
    course: CourseOf,
    hunts: HuntsOf,
    erreur: Annotated[str, Form(max_length=MAX_NAME)],
    fonction: Annotated[str, Form(max_length=MAX_NAME)],
    suite: Annotated[int, Form(ge=0, le=MAX_SKIP)] = 0,
    question: Annotated[Kind, Form()] = "entree",
    action: Annotated[Act, Form()] = "essayer",
    valeur: Typed = [],  # noqa: B006 (read by FastAPI, and never changed)
) -> Response:
    exercise, address = find_exercise(course, module, slug), client_address(request)
    hunt = HuntName(exercise=exercise.id, misconception=erreur, function=fonction)
    offer = await hunts.offer_hunt_again(account, hunt, address)
    outcome = None
    if offer is not None:
        offer = offer.model_copy(update={"index": suite})
        outcome = await judge_hunt_answer(hunts, account, offer, question, action, valeur, address)
    page = build_hunt_page(course, exercise, offer, question, valeur, outcome, gave_up=action == "abandonner")
    return await run_in_threadpool(render_page, request, "hunt.html", account, page=page)


async def judge_hunt_answer(
    hunts: HuntService,
    account: SignedIn,
    offer: OfferedHunt,
    question: Kind,
    action: Act,
    typed: Sequence[str],
    address: str,
) -> HuntTrialOutcome | None:
    """Judge what was typed, or note that the reader gives up (None)."""
    if question == "ligne":
        typed_line = typed[0] if typed else ""
        line = 0 if action == "abandonner" else int(typed_line) if is_line_number(typed_line) else -1
        return await hunts.try_line(account, offer.hunt, line, address)
    if action == "abandonner":
        await hunts.store_no_answer_found(account, offer.hunt, KINDS[question])
        return None
    if question == "prevision":
        return await hunts.try_prediction(account, offer.hunt, typed[0] if typed else "", address)
    names = [argument.name for argument in offer.arguments]
    return await hunts.try_input(account, offer.hunt, dict(zip(names, typed, strict=False)), address)


def choose_possible_question(offer: OfferedHunt, question: Kind) -> Kind:
    """Return the question where it can be asked about a hunt, else that for an input."""
    possible = {"entree": True, "prevision": offer.predictable, "ligne": offer.wrong_lines > 0}
    return question if possible[question] else "entree"


def is_line_number(typed: str) -> bool:
    return typed.isascii() and typed.isdigit() and len(typed) <= MAX_DIGITS


def build_hunt_page(
    course: Course,
    exercise: Exercise,
    offer: OfferedHunt | None,
    question: Kind,
    typed: Sequence[str] = (),
    outcome: HuntTrialOutcome | None = None,
    *,
    gave_up: bool = False,
) -> Mapping[str, Any]:
    """Return what the template of a hunt shows; the mistake is named once it is found, or given up."""
    is_over = gave_up or (outcome is not None and (outcome.is_right or question != "entree") and not outcome.refusal)
    mistake = None
    if offer is not None and is_over:
        catalogued = find_misconception(course, exercise.id, offer.hunt.misconception)
        family = find_family(course.families, exercise.filing, offer.hunt.misconception)
        mistake = {"title": catalogued.diagnosis.title, "text": catalogued.diagnosis.explanation, "family": family}
    values = [*typed, *[""] * MAX_ARGUMENTS]
    return {
        "module": build_module_link(course.modules[exercise.module]),
        "exercise_title": exercise.title,
        "exercise_href": exercise_href(exercise),
        "here": hunt_href(exercise),
        "offer": offer,
        "question": question,
        "lines": colour_python_lines(offer.program.rstrip("\n")) if offer is not None and question == "ligne" else (),
        "typed": values,
        "outcome": outcome,
        "is_over": is_over,
        "gave_up": gave_up,
        "mistake": mistake,
    }
