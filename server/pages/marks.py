"""Builds the marks of an attempt's answers, shown beside each question."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from graders.core.answers.question_paper import AnswerTranscript, Question
from graders.core.answers.reading import UnreadableAnswersError, is_blank, read_answers
from graders.core.contract.verdict import CheckResult, Verdict
from server.course import Exercise
from server.pages.schemas import MarkTone, MarkView
from server.submissions.models import Submission
from server.web import verdicts
from server.web.words import format_mark, format_points

SIGNS_AND_WORDS: Mapping[MarkTone, tuple[str, str]] = {
    "good": ("✓", "Juste"),
    "partial": ("½", "En partie juste"),
    "bad": ("✗", "À revoir"),
    "blank": ("○", "Sans réponse"),
}


def build_question_marks(
    exercise: Exercise, submission: Submission, verdict: Verdict | None, seed: int | None
) -> tuple[MarkView, ...]:
    """Return a mark for each question of the page, which shows the deal of `seed`.

    Empty ones (of tone "none") where there is nothing to say of a question by itself: no verdict yet, steps to be
    ordered, another deal, a file that could not be read, a question that the exercise did not have.
    """
    if exercise.answers is None:
        return ()
    questions = exercise.answers.paper(submission.seed).questions
    answers = _read_answers_or_none(submission)
    if (
        verdict is None
        or answers is None
        or submission.seed != seed
        or verdicts.message_shared_by_checks(verdict.checks)
    ):
        return tuple(_empty_mark_view(question) for question in questions)
    checks = {check.id: check for check in verdict.checks}
    transcripts = {answer.question: answer for answer in exercise.answers.transcribe(answers, submission.seed)}
    return tuple(
        _empty_mark_view(question)
        if question.form == "order" or question.id not in checks
        else _build_mark_view(
            exercise, checks[question.id], transcripts.get(question.id), blank=is_blank(answers.get(question.id))
        )
        for question in questions
    )


def _read_answers_or_none(submission: Submission) -> Mapping[str, Any] | None:
    try:
        return read_answers(submission.source)
    except UnreadableAnswersError:
        return None


def _empty_mark_view(question: Question) -> MarkView:
    return MarkView(question.id, "none", "", "", "", "", "", "", "", "")


def _build_mark_view(
    exercise: Exercise, check: CheckResult, transcript: AnswerTranscript | None, *, blank: bool
) -> MarkView:
    tone: MarkTone = "good" if check.passed else "blank" if blank else "partial" if check.points else "bad"
    sign, word = SIGNS_AND_WORDS[tone]
    expected = check.counterexample.expected if check.counterexample else None
    return MarkView(
        question=check.id,
        tone=tone,
        sign=sign,
        word=word,
        points=format_mark(check.points, check.max_points),
        max_points=format_points(check.max_points),
        answered=_format_given_answer(transcript) if transcript else "",
        expected=exercise.render_line(expected) if isinstance(expected, str) else "",
        message="" if blank else exercise.render_paragraphs(check.message),
        hint=exercise.render_line(check.hint) if check.hint else "",
    )


def _format_given_answer(transcript: AnswerTranscript) -> str:
    return ", ".join(piece.id for piece in transcript.pieces) or transcript.text
