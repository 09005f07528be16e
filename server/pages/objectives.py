"""Where a reader stands in a module: what stands, what fades, what to do now, and the way to the end."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from fastapi import APIRouter, Request
from fastapi.responses import Response

from server.board.objective_loading import load_own_objective_states
from server.board.objectives import RULE, Mastery, MisconceptionLookup, ObjectiveState
from server.course import Course, Exercise, Module
from server.course.lengths import estimate_exercise_minutes, estimate_reading_minutes
from server.course.objectives import Objective
from server.database import utc_now
from server.gradebook import service as gradebook
from server.gradebook.schemas import NOTHING_YET, ExerciseProgress
from server.hunts.service import may_ask_about_mistakes_again
from server.pages.two_minutes import PATH as TWO_MINUTES
from server.recall import paths, retrievals
from server.recall.service import RecallCandidate, RecallState, load_account_recall_state
from server.recall.subjects import title_of_subject
from server.web.dependencies import CurrentReader
from server.web.next_step import NextExercise, choose_next_exercise, list_exercises_of_path
from server.web.own_objectives import (
    StudentObjectiveRow,
    build_objective_row,
    count_states_in_words,
    group_objectives_by_lesson,
)
from server.web.rendering import render_page
from server.web.views import (
    Reader,
    build_module_link,
    exercise_href,
    find_module,
    lesson_href,
    lessons_in_reading_order,
)
from server.web.words import count_with_noun

router = APIRouter(include_in_schema=False)

MINUTES_A_QUESTION = 0.5
BEGINNING = "c’est par là que l’on commence"


@dataclass(frozen=True)
class NextTask:
    """The one thing to do now: its button, how long it takes in minutes (0: not known), and why, a clause."""

    href: str
    label: str
    minutes: int
    reason: str


@dataclass(frozen=True)
class RemainingWay:
    """The way to the end: the exercises that are left, each with its address, title and minutes."""

    path: str
    solved: int
    total: int
    left: tuple[tuple[str, str, int], ...]

    @property
    def minutes(self) -> int:
        return sum(minutes for _, _, minutes in self.left)


@router.get("/{module:module}/objectifs")
def show_objectives(request: Request, module: str, reader: CurrentReader) -> Response:
    """Show one's own objectives, to nobody else; the teacher's page is made of the same states."""
    course_module = find_module(reader.course, module)
    return render_page(request, "objectives.html", reader.account, page=build_objectives_page(reader, course_module))


def build_objectives_page(reader: Reader, module: Module) -> Mapping[str, Any]:
    """Build the page of a reader, without queries for one who has no account yet."""
    progress: Mapping[str, ExerciseProgress] = {}
    choices: Mapping[str, str] = {}
    recall: RecallState | None = None
    states: Sequence[ObjectiveState] = ()
    if reader.account is not None:
        progress = gradebook.load_progress(reader.db, reader.account)
        choices = paths.load_chosen_paths(reader.db, reader.account.id)
        recall = _load_recall_state(reader, progress, choices)
        states = load_own_objective_states(reader.db, reader.course, module, reader.account.id, utc_now())
    rows = [build_objective_row(reader.course, module.slug, state) for state in states]
    fading = find_fading_misconceptions(reader.course, module, rows, {} if recall is None else recall.fading)
    path = paths.find_chosen_path(module, choices)
    following = choose_next_exercise(module, progress, path)
    way = list_exercises_of_path(module, path)
    left = [exercise for exercise in way if not _is_solved(progress, exercise)]
    return {
        "module": build_module_link(module),
        "begun": any(progress.get(exercise.id, NOTHING_YET).attempts for exercise in module.exercises),
        "proposal": propose_next_task(module, rows, recall, fading, following),
        "rows": rows,
        "groups": group_objectives_by_lesson(reader.course, module.slug, rows),
        "counts": count_states_in_words(rows),
        "fading": fading,
        "two_minutes": TWO_MINUTES,
        "way": RemainingWay(
            path="" if path is None else path.title,
            solved=len(way) - len(left),
            total=len(way),
            left=tuple(
                (exercise_href(exercise), exercise.title, estimate_exercise_minutes(exercise)) for exercise in left
            ),
        ),
        "has_paths": any(way.exercises for way in module.paths),
        "rule": RULE,
    }


def _load_recall_state(
    reader: Reader, progress: Mapping[str, ExerciseProgress], choices: Mapping[str, str]
) -> RecallState | None:
    solved = {name for name in progress if progress[name].succeeded}
    if reader.account is None:
        return None
    course = reader.course
    return load_account_recall_state(
        reader.db,
        course,
        reader.account.id,
        solved,
        lambda exercise: may_ask_about_mistakes_again(course, exercise),
        choices,
    )


def _is_solved(progress: Mapping[str, ExerciseProgress], exercise: Exercise) -> bool:
    return progress.get(exercise.id, NOTHING_YET).succeeded


def find_fading_misconceptions(
    course: Course, module: Module, rows: Sequence[StudentObjectiveRow], fading: Mapping[str, Sequence[RecallCandidate]]
) -> Mapping[str, Sequence[str]]:
    """Return, by the id of an objective, the titles of the mended misconceptions of it that are fading. Pure."""
    lookup = MisconceptionLookup(course)
    found: dict[str, list[str]] = {}
    for row in rows:
        objective: Objective = row.objective.objective
        for subject, candidates in fading.items():
            own = [
                candidate
                for candidate in candidates
                if candidate.exercise.startswith(f"{module.slug}/")
                and lookup.belongs_to_objective(objective, candidate.exercise, candidate.misconception)
            ]
            if own:
                title = title_of_subject(course, subject) or lookup.misconception_title(
                    own[0].exercise, own[0].misconception
                )
                found.setdefault(objective.id, []).append(title)
    return found


def propose_next_task(
    module: Module,
    rows: Sequence[StudentObjectiveRow],
    recall: RecallState | None,
    fading: Mapping[str, Sequence[str]],
    following: NextExercise | None,
) -> NextTask | None:
    """Return the one thing to do now: what fades, or the next exercise; where to begin, for a newcomer. Pure."""
    if recall is not None and recall.due and not recall.is_off:
        count = len(recall.due)
        titles = dict.fromkeys(title for row in rows for title in fading.get(row.objective.objective.id, ()))
        why = _explain_recall(recall.due, next(iter(titles), ""))
        label = f"Deux minutes : {count_with_noun(count, 'question')}"
        return NextTask(TWO_MINUTES, label, max(1, round(count * MINUTES_A_QUESTION)), why)
    if following is not None and any(row.state is not Mastery.none for row in rows):
        return _propose_exercise(rows, following)
    way = lessons_in_reading_order(module)
    if following is not None and way:
        minutes = round(estimate_reading_minutes(way[0]))
        return NextTask(lesson_href(way[0]), f"Commencer : {way[0].label}", minutes, "c’est par là que l’on commence")
    return None


def _explain_recall(due: Collection[str], first: str) -> str:
    """Say why these subjects are to be seen again: mended mistakes fade (`first` is one), lessons' questions were
    missed."""
    missed = sum(subject.startswith(retrievals.PREFIX) for subject in due)
    questions = "vous aviez manqué une question d’une séance"
    if missed > 1:
        questions = f"vous aviez manqué {count_with_noun(missed, 'question')} des séances"
    if missed == len(due):
        return questions
    fades = "ce que vous aviez corrigé commence à s’effacer" + (f" (« {first} »)" if first else "")
    return f"{fades}, et {questions}" if missed else fades


def _propose_exercise(rows: Sequence[StudentObjectiveRow], following: NextExercise) -> NextTask:
    verb = "Reprendre" if following.is_begun else "Exercice suivant"
    own = [row for row in rows if following.exercise.id in row.objective.exercises]
    weak = next((row for row in own if row.mistakes), None)
    reason = following.reason
    if weak is not None:
        reason = f"votre dernière erreur y était « {weak.mistakes[0]} »"
    elif own and reason:
        reason = f"{reason}, et il fait avancer l’objectif « {own[0].short} »"
    label = f"{verb} : {following.exercise.title}"
    return NextTask(following.href, label, estimate_exercise_minutes(following.exercise), reason)
