"""What there is to solve."""

from dataclasses import asdict

from fastapi import APIRouter

from graders.core.answers import Paper, Question
from server.api.documentation import problem_responses
from server.api.schemas import (
    ExerciseDetail,
    ExerciseOut,
    FunctionOut,
    GivenOut,
    LimitsOut,
    PieceOut,
    PromiseOut,
    QuestionOut,
)
from server.base import root_path
from server.base.errors import NotFound
from server.course.dependencies import CourseOf
from server.course.models import Course, Exercise
from server.database.dependencies import DatabaseOf
from server.identity.dependencies import ApiAccount
from server.submissions import variants

router = APIRouter(tags=["exercises"])
NO_PAPER = Paper((), ())


def find_exercise_by_id(course: Course, exercise_id: str) -> Exercise:
    exercise = course.exercises.get(exercise_id)
    if exercise is None:
        raise NotFound(f"L’exercice « {exercise_id} » n’existe pas.")
    return exercise


@router.get("/exercises", responses=problem_responses(401))
def list_exercises(course: CourseOf, _account: ApiAccount) -> list[ExerciseOut]:
    """Every exercise that is served, in the order of the course."""
    return [_exercise_out(exercise) for exercise in course.exercises.values()]


@router.get("/exercises/{module}/{slug}", responses=problem_responses(401, 404))
def read_exercise(
    module: str, slug: str, course: CourseOf, account: ApiAccount, database: DatabaseOf
) -> ExerciseDetail:
    """One exercise, with its statement (HTML), the file to start from, and the limits of an execution.

    An exercise answered without code comes with the questions that were dealt to this account.
    """
    exercise = find_exercise_by_id(course, f"{module}/{slug}")
    paper = NO_PAPER
    if exercise.answers is not None:
        paper = exercise.answers.paper(variants.ensure_seed(database, account, exercise.id))
    return ExerciseDetail(
        **_exercise_out(exercise).model_dump(),
        statement_html=exercise.statement_html,
        starter=exercise.starter,
        limits=LimitsOut(**asdict(exercise.policy)),
        given=[
            GivenOut(symbol=datum.symbol, name=datum.name, value=datum.text, unit=datum.unit) for datum in paper.given
        ],
        questions=[_question_out(exercise, question) for question in paper.questions],
    )


def _question_out(exercise: Exercise, question: Question) -> QuestionOut:
    return QuestionOut(
        id=question.id,
        title=question.title,
        text_html=exercise.render_paragraphs(question.text),
        form=question.form,
        points=question.points,
        unit=question.unit,
        pieces=[PieceOut(id=piece.id, text_html=exercise.render_paragraphs(piece.text)) for piece in question.pieces],
    )


def _exercise_out(exercise: Exercise) -> ExerciseOut:
    return ExerciseOut(
        id=exercise.id,
        module=exercise.module,
        slug=exercise.slug,
        title=exercise.title,
        summary=exercise.summary,
        stars=exercise.stars,
        course=exercise.origin,
        version=exercise.version,
        kind=exercise.kind,
        functions=[
            FunctionOut(
                name=f.name,
                signature=f.signature,
                returns=f.returns,
                doc=f.doc,
                promises=[PromiseOut(label=label, text=text) for label, text in f.promises],
            )
            for f in exercise.functions
        ],
        url=root_path.external_path(f"/api/v1/exercises/{exercise.id}"),
    )
