"""Prepare the questions of a class for a day, store what students answer, count it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from datetime import date, datetime
from functools import partial
from uuid import UUID

from sqlalchemy.orm import Session
from starlette.concurrency import run_in_threadpool

from server.base.errors import Conflict, Invalid, NotFound
from server.board.progress import ClassProgress
from server.board.relapses import RelapseStats, count_relapses
from server.board.schemas import FEWEST_TO_PROJECT
from server.board.service import load_class_progress
from server.classes.models import SchoolClass
from server.classes.service import require_not_archived
from server.course import Course, Exercise
from server.database import Database, utc_now
from server.gradebook.mistakes import PastMistake, iter_past_mistakes
from server.hunts.service import HuntService, hunt_names_of_misconceptions, may_have_hunts
from server.identity.models import Account
from server.lesson.service import load_projection_rules
from server.polls import repository as polls
from server.recall import repository as recall
from server.recall import retrievals
from server.recall.models import QuestionKind, RecallAnswer
from server.recall.service import RecallCandidate, collect_reviews_by_subject, list_family_candidates
from server.recall.subjects import subject_of_misconception
from server.rights import service as rights
from server.rights.models import Right
from server.warmup import repository
from server.warmup.making import build_comparison_question, build_retrieval_question, daily_subject_seed
from server.warmup.models import WarmUp
from server.warmup.needs import StudentRecallHistory, SubjectReviewNeed, rank_subjects_to_review
from server.warmup.schemas import OptionCount, QuestionWithCounts, WarmUpQuestion

MayAsk = Callable[[Exercise], bool]
QUESTIONS = 3
#: Subjects that are tried until there are `QUESTIONS` questions.
MAX_TRIED = 8
TOO_FEW = f"Ces questions demandent {FEWEST_TO_PROJECT} élèves au moins dans la classe."
NOTHING = (
    "Rien à revoir tous ensemble pour l’instant : les questions viennent des erreurs qu’au moins "
    f"{FEWEST_TO_PROJECT} élèves ont faites, et des questions des séances qu’ils ont manquées."
)
NO_QUESTION = "Cette question n’existe pas, ou n’est plus d’aujourd’hui."
NO_OPTION = "Choisissez l’une des réponses proposées."


@dataclass(frozen=True)
class WarmUpService:
    """Makes the questions of a class, with the process that runs hunts."""

    course: Course
    database: Database
    hunts: HuntService

    async def prepare_today(self, account: Account, class_id: str, address: str) -> None:
        """Store the questions of today, unless there are some. Raises NotFound, Forbidden, Conflict or what
        `HuntService` raises."""
        day = retrievals.today_at_school()
        planned = await run_in_threadpool(self._load_needs_unless_prepared, account, class_id, day)
        if planned is None:
            return
        identity, needs = planned
        questions: list[WarmUpQuestion] = []
        for need in needs[:MAX_TRIED]:
            if len(questions) < QUESTIONS:
                question = await self._make_question(
                    account, need, daily_subject_seed(str(identity), day.isoformat(), need.subject), address
                )
                questions += [] if question is None else [question]
        if not questions:
            raise Conflict(NOTHING)
        await run_in_threadpool(self._store_questions, identity, day, questions)

    def _load_needs_unless_prepared(
        self, account: Account, class_id: str, day: date
    ) -> tuple[UUID, Sequence[SubjectReviewNeed]] | None:
        """Return what the class is to see again; None where today's questions stand already."""
        with self.database.read() as db:
            access = rights.require_right(db, account, Right.run_lessons, class_id)
            require_not_archived(access.school_class)
            if repository.find_warm_up(db, access.school_class.id, day) is not None:
                return None
            return access.school_class.id, load_subjects_to_review(db, self.course, access.school_class, utc_now())

    async def _make_question(
        self, account: Account, need: SubjectReviewNeed, seed: int, address: str
    ) -> WarmUpQuestion | None:
        found = retrievals.find_retrieval_of_subject(self.course, need.subject)
        if found is not None:
            return await run_in_threadpool(build_retrieval_question, *found, need, seed)
        comparison = await self.hunts.find_distinguishing_call(
            account, hunt_names_of_misconceptions(need.candidates), address
        )
        return None if comparison is None else build_comparison_question(self.course, need, comparison, seed)

    def _store_questions(self, class_id: UUID, day: date, questions: Sequence[WarmUpQuestion]) -> None:
        with self.database.write() as db:
            repository.add_warm_up_if_absent(db, class_id, day, [question.to_data() for question in questions])


def load_subjects_to_review(
    db: Session, course: Course, school_class: SchoolClass, now: datetime
) -> Sequence[SubjectReviewNeed]:
    """Load what a class is to see again, those of most students first. Raises Conflict for too few students."""
    progress = load_class_progress(db, course, school_class, now)
    if len(progress.students) < FEWEST_TO_PROJECT:
        raise Conflict(TOO_FEW)
    may_ask = partial(_may_ask_hunt_of_exercise, course, _exercises_with_held_back_feedback(db, progress))
    needs = rank_subjects_to_review(_load_recall_histories(db, progress, may_ask), now)
    module = course.modules.get(school_class.module)
    exercises = [] if module is None else list(module.exercises)
    return [
        SubjectReviewNeed(
            need.subject, need.students_to_review, need.students_confused,
            tuple(dict.fromkeys([*need.candidates, *list_family_candidates(course, exercises, need.subject, may_ask)])),
        )
        for need in needs
    ]  # fmt: skip


def _exercises_with_held_back_feedback(db: Session, progress: ClassProgress) -> frozenset[str]:
    """Return the exercises of which something is held back from a student."""
    students = [student.id for student in progress.students]
    names = {exercise for _, exercise in progress.attempts}
    return frozenset(name for name in names if load_projection_rules(db, students, name).refusal)


def _may_ask_hunt_of_exercise(course: Course, held_back: frozenset[str], exercise: Exercise) -> bool:
    return exercise.id not in held_back and may_have_hunts(course, exercise)


def _load_recall_histories(
    db: Session, progress: ClassProgress, may_ask: MayAsk
) -> Mapping[UUID, StudentRecallHistory]:
    """Return what each student confused, with one query for the answers of all."""
    course = progress.course
    answers: dict[UUID, list[RecallAnswer]] = {student.id: [] for student in progress.students}
    for answer in recall.load_recall_answers_of_accounts(db, answers.keys()):
        answers[answer.account_id].append(answer)
    past: dict[UUID, list[PastMistake]] = {student: [] for student in answers}
    for (account, exercise), attempts in progress.attempts.items():
        if account in past and exercise in course.exercises and may_ask(course.exercises[exercise]):
            past[account] += iter_past_mistakes(attempts)
    return {student: _build_recall_history(course, past[student], own, may_ask) for student, own in answers.items()}


def _build_recall_history(
    course: Course, past: Sequence[PastMistake], answers: Sequence[RecallAnswer], may_ask: MayAsk
) -> StudentRecallHistory:
    reviews, confused = collect_reviews_by_subject(course, past, answers, may_ask)
    met: dict[str, list[RecallCandidate]] = {subject: list(own) for subject, own in confused.items()}
    unmended = set()
    for mistake in past:
        if mistake.mended is None:
            subject = subject_of_misconception(course, course.exercises[mistake.exercise], mistake.misconception)
            unmended.add(subject)
            met.setdefault(subject, []).append(RecallCandidate(mistake.exercise, mistake.misconception))
    return StudentRecallHistory(reviews, met, unmended)


def load_relapse_stats(db: Session, course: Course, school_class: SchoolClass) -> RelapseStats:
    """Load whether what was asked again is rarer later, with one query beside those of the class's progress."""
    progress = load_class_progress(db, course, school_class, utc_now())
    answers = recall.load_recall_answers_of_accounts(db, [student.id for student in progress.students])
    return count_relapses(course, progress.attempts, answers)


def find_todays_warm_up(db: Session, class_id: UUID) -> WarmUp | None:
    """Return the questions of today."""
    return repository.find_warm_up(db, class_id, retrievals.today_at_school())


def parse_stored_questions(warm_up: WarmUp) -> Sequence[WarmUpQuestion]:
    return [WarmUpQuestion.from_data(data) for data in warm_up.questions]


def question_poll_name(school_class: SchoolClass, warm_up: WarmUp, question_index: int) -> str:
    """Return the name under which answers to a question are stored among those to polls."""
    return f"{school_class.module}/pour-commencer/{warm_up.id}/{question_index}"


def question_poll_names(school_class: SchoolClass, warm_up: WarmUp) -> Sequence[str]:
    return [question_poll_name(school_class, warm_up, number) for number in range(len(warm_up.questions))]


def store_student_answer(
    db: Session, account: Account, school_class: SchoolClass, question_index: int, option_id: str
) -> None:
    """Store a student's first answer to a question of today. Raises NotFound or Invalid."""
    warm_up = find_todays_warm_up(db, school_class.id)
    questions = [] if warm_up is None else parse_stored_questions(warm_up)
    if warm_up is None or not 0 <= question_index < len(questions):
        raise NotFound(NO_QUESTION)
    question = questions[question_index]
    if question.find_option(option_id) is None:
        raise Invalid(NO_OPTION)
    name = question_poll_name(school_class, warm_up, question_index)
    if polls.load_first_answers(db, account.id, [name]):
        return
    polls.save_first_answer(db, account.id, name, option_id)
    recall.add_answer(db, RecallAnswer(
        account_id=account.id, subject=question.subject, kind=QuestionKind.calculation, exercise=question.exercise,
        misconception=question.misconception, is_right=option_id == question.right,
    ))  # fmt: skip


def load_own_answers(db: Session, account_id: UUID, school_class: SchoolClass, warm_up: WarmUp) -> Mapping[int, str]:
    """Return what a student answered to each question, by its number."""
    names = {question_poll_name(school_class, warm_up, number): number for number in range(len(warm_up.questions))}
    return {names[name]: said for name, said in polls.load_first_answers(db, account_id, list(names)).items()}


def count_answers(db: Session, school_class: SchoolClass, warm_up: WarmUp) -> Sequence[QuestionWithCounts]:
    """Count the answers of the present students of the class to each question, in one query."""
    names = question_poll_names(school_class, warm_up)
    said = polls.load_answer_counts(db, school_class.id, names)
    counted = []
    for name, question in zip(names, parse_stored_questions(warm_up), strict=True):
        chosen = {
            option.id: sum(row.students for row in said if row.poll == name and row.first == option.id)
            for option in question.options
        }
        counted.append(
            QuestionWithCounts(question, [OptionCount(option, chosen[option.id]) for option in question.options])
        )
    return counted
