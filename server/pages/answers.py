"""The page of an exercise answered without code: its questions for one account, and what comes back from the form."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import lru_cache
from itertools import pairwise
from typing import Any

from markupsafe import Markup
from starlette.datastructures import FormData

from graders.core.answers import AnswersGrader, Question
from graders.core.answers.question_paper import AnswerTranscript
from graders.core.answers.reading import UnreadableAnswersError, display_text, read_answers
from server.base.errors import Invalid
from server.course import Exercise
from server.gradebook import service as gradebook
from server.gradebook.schemas import Attempt
from server.pages import service, withheld
from server.pages.schemas import AnswersPage, GivenDatumView, OptionOrStepView, QuestionView, TranscriptView
from server.submissions.models import Submission
from server.web.rendering import jinja_environment
from server.web.views import Reader
from server.web.words import format_points

FIELD, PLACE = "q.", "place."  # the names of the form's fields: q.<question>, place.<question>.<step>
MOST_OPTIONS = 1024
SAME_PLACE = "Deux étapes portent le même numéro : revenez en arrière et donnez une place à chacune."


def build_answers_page(reader: Reader, exercise: Exercise, seed: int, taken: Attempt | None) -> AnswersPage:
    """The questions of `seed`; the fields hold the answers of `taken`, else of the last attempt."""
    grader = _answers_grader(exercise)
    latest = gradebook.find_latest_attempt(reader.db, reader.account, exercise.id)
    paper = grader.paper(seed)
    saved = withheld.load_saved_work(reader, exercise, latest) if taken is None else None
    put_back = taken or latest
    if saved is not None:
        answers = grader.translate_letters(read_answers(saved.source), seed, seed)
    else:
        answers = _read_relettered_answers(grader, put_back.submission if put_back else None, seed)
    sections = ["", *(question.section for question in paper.questions)]
    heads = [section if section != before else "" for before, section in pairwise(sections)]
    return AnswersPage(
        **service.build_common_fields(reader, exercise, latest, saved, seed),
        given=tuple(
            GivenDatumView(exercise.render_line(f"${datum.symbol}$"), datum.name, datum.text, datum.unit)
            for datum in paper.given
        ),
        questions=tuple(
            build_question_view(exercise, number, question, answers.get(question.id), heads[number - 1])
            for number, question in enumerate(paper.questions, 1)
        ),
        seed=str(seed),
        taken=taken is not None,
    )


def _answers_grader(exercise: Exercise) -> AnswersGrader:
    assert exercise.answers is not None
    return exercise.answers


def _read_relettered_answers(grader: AnswersGrader, submission: Submission | None, seed: int) -> Mapping[str, Any]:
    if submission is None:
        return {}
    try:
        return grader.translate_letters(read_answers(submission.source), submission.seed, seed)
    except UnreadableAnswersError:
        return {}


def build_question_view(exercise: Exercise, number: int, question: Question, answer: Any, section: str) -> QuestionView:
    chosen = answer if isinstance(answer, list) else [answer]
    places = {letter: place for place, letter in enumerate(chosen, 1) if isinstance(letter, str)}
    order = question.form == "order"
    pieces = tuple(
        OptionOrStepView(
            piece.id,
            exercise.render_line(piece.text),
            piece.id in places,
            _render_place_options(len(question.pieces), places.get(piece.id, 0)) if order else Markup(),
        )
        for piece in question.pieces
    )
    return QuestionView(
        id=question.id,
        number=number,
        title=exercise.render_line(question.title),
        html=exercise.render_paragraphs(question.text),
        form=question.form,
        field=(PLACE if order else FIELD) + question.id,
        points=format_points(question.points),
        unit=question.unit,
        value=display_text(answer) if question.form == "number" and isinstance(answer, str | int | float) else "",
        pieces=pieces,
        section=section,
    )


@lru_cache(maxsize=MOST_OPTIONS)
def _render_place_options(count: int, chosen: int) -> Markup:
    """Of each step the same, but for the one that is chosen (0: none)."""
    macros: Any = jinja_environment().get_template("exercise_answers_options.html").module
    return Markup(macros.options(count, chosen))


def read_answers_form(exercise: Exercise, fields: FormData) -> dict[str, Any]:
    """The answers in a form, as the API takes them; what was left empty is absent. Raises Invalid."""
    read = {
        "number": _read_typed_answer,
        "one": _read_typed_answer,
        "several": _read_ticked_options,
        "order": _read_placed_steps,
    }
    questions = _answers_grader(exercise).paper(0).questions
    values = {question.id: read[question.form](fields, question) for question in questions}
    return {name: value for name, value in values.items() if value}


def _read_typed_answer(fields: FormData, question: Question) -> Any:
    value = fields.get(FIELD + question.id, "")
    return value.strip() if isinstance(value, str) else ""


def _read_ticked_options(fields: FormData, question: Question) -> Any:
    return [value for value in fields.getlist(FIELD + question.id) if isinstance(value, str)]


def _read_placed_steps(fields: FormData, question: Question) -> Any:
    places: dict[int, str] = {}
    for piece in question.pieces:
        value = fields.get(f"{PLACE}{question.id}.{piece.id}", "")
        if isinstance(value, str) and value.isascii() and value.isdigit() and len(value) < 4 and int(value):
            if int(value) in places:
                raise Invalid(SAME_PLACE)
            places[int(value)] = piece.id
    return [places[place] for place in sorted(places)]


def build_transcript(exercise: Exercise, submission: Submission) -> Sequence[TranscriptView]:
    """Return the answers of an attempt for reading; blank questions too, where at least one was answered."""
    grader = _answers_grader(exercise)
    try:
        answers = read_answers(submission.source)
    except UnreadableAnswersError:
        return [TranscriptView("", "Fichier envoyé", display_text(submission.code), ())]
    given = {answer.question: answer for answer in grader.transcribe(answers, submission.seed)}
    questions = grader.paper(submission.seed).questions if given else ()
    return [
        build_transcript_view(exercise, given[question.id])
        if question.id in given
        else TranscriptView(question.id, exercise.render_line(question.title), "", ())
        for question in questions
    ]


def build_transcript_view(exercise: Exercise, answer: AnswerTranscript) -> TranscriptView:
    pieces = tuple((piece.id, exercise.render_line(piece.text)) for piece in answer.pieces)
    return TranscriptView(answer.question, exercise.render_line(answer.title), answer.text, pieces)
