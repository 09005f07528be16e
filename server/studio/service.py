"""A teacher's own exercises: saved as they are typed, tried behind the walls, published once they hold.

Every function works inside the caller's transaction. What an author has written runs in the sandbox alone, in a job of
the queue: here it is text.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any
from uuid import UUID

from sqlalchemy.orm import Session

from graders.core.declared.declaration import MAX_PROGRAM
from graders.core.declared.trial_report import TrialReport, TriedChange, TriedMistake
from graders.typography import unaccented
from server.base.errors import Conflict, Invalid, NotFound, RateLimited
from server.base.settings import Settings
from server.base.validation import parse_uuid
from server.classes.models import SchoolClass
from server.database import utc_now
from server.identity.models import Account
from server.limits import service as limits
from server.queue.interfaces import BacklogLimits, Queue, QueueFullError, Sender
from server.studio import repository
from server.studio.drafts import (
    MAX_CASES,
    MAX_CHARACTERS,
    MAX_CHECKS,
    MAX_MISTAKES,
    CaseDraft,
    ExerciseDraft,
    MistakeDraft,
)
from server.studio.mistake_words import explanation_for_operator, title_for_operator
from server.studio.models import AuthoredExercise
from server.studio.publication import draw_share_code, draw_slug

#: The kind of the job that tries a draft; its key is the exercise's id.
TRIAL_JOB = "trial"
#: The kind of the job that grades a program on a draft, for its author.
TRYOUT_JOB = "tryout"
#: Below every submission, above regrades (see `server.submissions.queue_senders`).
TRIAL_RANK = 5
MAX_EXERCISES, MAX_WAITING = 300, 6
SHARE_CODE_LENGTH = 10
#: The actions by which an author lends an exercise, or no longer does.
SHARE, WITHDRAW, TO_BANK, FROM_BANK, TO_CLASSES, FROM_CLASSES = LENDING = (
    "partager", "ne-plus-partager", "banque", "hors-banque", "classes", "hors-classes",
)  # fmt: skip
UNKNOWN = "Cet exercice n’est pas à vous, ou n’existe plus."
UNKNOWN_CODE = "Aucun exercice n’a ce code : vérifiez-le avec votre collègue."
TOO_MANY = f"Vous avez {MAX_EXERCISES} exercices : supprimez-en un avant d’en commencer un autre."
TOO_LONG = "Cet exercice a {length} caractères en tout ; {most} au plus. Rien n’est perdu : raccourcissez-le."
TOO_FAST = "Vous enregistrez très souvent : le prochain est possible dans {seconds} s. Rien n’est perdu."
TOO_MANY_CODES = "Trop de codes inconnus de suite : réessayez dans {seconds} s."
CODE_TOO_LONG = "Ce programme a {length} caractères ; {most} au plus."
NOT_TRIED = "Cet exercice n’a pas encore été essayé : enregistrez-le, puis reprenez l’archive."
NOTHING_PICKED = "Vous n’avez coché aucun cas : cochez ceux que votre énoncé admet, puis ajoutez-les."
NO_MISTAKE_PICKED = "Vous n’avez coché aucune erreur : cochez celles que vos élèves font, puis ajoutez-les."
OUT_OF_DATE = "L’essai a changé depuis que vous l’avez lu : cochez de nouveau ce que vous voulez ajouter."
PUBLISHED = "Cet exercice est publié : des élèves l’ont peut-être fait. Il ne se supprime plus."


@dataclass(frozen=True)
class StudioService:
    """Saves and tries the exercises of teachers, within the settings' limits."""

    settings: Settings
    queue: Queue

    def create_exercise(
        self, db: Session, account: Account, module: str, draft: ExerciseDraft | None = None
    ) -> AuthoredExercise:
        """Create an exercise. Raises Conflict where the author has too many."""
        if repository.count_exercises(db, account.id) >= MAX_EXERCISES:
            raise Conflict(TOO_MANY)
        limits.take_token(db, _token_bucket_key(account), self.settings.save_bucket, TOO_FAST)
        draft = draft or ExerciseDraft()
        made = AuthoredExercise(author_id=account.id, module=module, draft=draft.to_data(), digest=draft.digest)
        db.add(made)
        db.flush()
        return made

    def save_draft_and_try(
        self, db: Session, account: Account, exercise: AuthoredExercise, draft: ExerciseDraft, *, publish: bool = False
    ) -> None:
        """Store a draft, and have it tried. Raises Invalid for one that is too long, or RateLimited."""
        require_draft_within_limits(draft)
        limits.take_token(db, _token_bucket_key(account), self.settings.save_bucket, TOO_FAST)
        if is_current_draft_published(exercise):  # an earlier form may have given another digest to the same draft
            exercise.trial = {**(exercise.trial or {}), "published_digest": read_draft(exercise).digest}
        exercise.draft, exercise.digest, exercise.saved_at = draft.to_data(), draft.digest, utc_now()
        exercise.wants_publication = publish
        if publish and exercise.slug is None:
            exercise.slug = draw_slug(draft.title or draft.functions)
        db.flush()
        self.request_trial(db, exercise)

    def request_trial(self, db: Session, exercise: AuthoredExercise) -> None:
        """Enqueue the trial of an exercise, in its author's flow. Raises RateLimited where too many wait.

        A trial that runs already is followed by another one, which its end enqueues.
        """
        if not self.is_trial_queued(db, exercise):
            enqueue_trial(db, self.queue, exercise)

    def grade_as_student(self, db: Session, account: Account, exercise: AuthoredExercise, code: str) -> None:
        """Have a program graded on the draft as it was last tried; nothing of it counts.

        Raises Invalid, Conflict for a draft that was not tried, or RateLimited.
        """
        content_to_archive(exercise)
        if len(code) > MAX_PROGRAM:
            raise Invalid(CODE_TOO_LONG.format(length=len(code), most=MAX_PROGRAM))
        limits.take_token(db, _token_bucket_key(account), self.settings.save_bucket, TOO_FAST)
        exercise.tryout = {"code": code}
        db.flush()
        if not self.is_trial_queued(db, exercise, TRYOUT_JOB):
            enqueue_tryout(db, self.queue, exercise)

    def count_wrong_code(self, db: Session, account: Account) -> None:
        """Count a code that no exercise bears. Raises RateLimited."""
        limits.take_token(db, f"studio-code:{account.id}", self.settings.join_bucket, TOO_MANY_CODES)

    def is_trial_queued(self, db: Session, exercise: AuthoredExercise, kind: str = TRIAL_JOB) -> bool:
        return self.queue.position(db, kind, str(exercise.id)) is not None


def enqueue_trial(db: Session, queue: Queue, exercise: AuthoredExercise) -> None:
    """Enqueue the trial of an exercise. Raises RateLimited where too many of its author's wait."""
    _enqueue(db, queue, TRIAL_JOB, exercise)


def enqueue_tryout(db: Session, queue: Queue, exercise: AuthoredExercise) -> None:
    """Enqueue the grading of its author's program on an exercise. Raises RateLimited where too many jobs wait."""
    _enqueue(db, queue, TRYOUT_JOB, exercise)


def _enqueue(db: Session, queue: Queue, kind: str, exercise: AuthoredExercise) -> None:
    flow = f"studio {exercise.author_id}"
    sender = Sender(flow, flow=flow, rank=TRIAL_RANK)
    try:
        queue.enqueue(db, kind, str(exercise.id), sender=sender, limits=BacklogLimits(MAX_WAITING, 10**6))
    except QueueFullError as error:
        raise RateLimited(TOO_FAST.format(seconds=10), retry_after=10) from error


def require_draft_within_limits(draft: ExerciseDraft) -> None:
    """Raise Invalid for a draft that is longer than one may be."""
    if draft.character_count > MAX_CHARACTERS:
        raise Invalid(TOO_LONG.format(length=draft.character_count, most=MAX_CHARACTERS))
    for count, most, what in (
        (len(draft.checks), MAX_CHECKS, "vérifications"),
        (max((len(check.cases) for check in draft.checks), default=0), MAX_CASES, "cas par vérification"),
        (len(draft.mistakes), MAX_MISTAKES, "erreurs connues"),
    ):
        if count > most:
            raise Invalid(f"{count} {what} ; {most} au plus. Rien n’est perdu : retirez-en.")


def find_own_exercise(
    db: Session, account: Account, exercise_id: UUID | str, *, to_change: bool = False
) -> AuthoredExercise:
    """Return an exercise of this author; `to_change` locks it until the commit. Raises NotFound."""
    wanted = parse_uuid(exercise_id, UNKNOWN)
    find = repository.lock_exercise if to_change else repository.find_exercise
    exercise = find(db, wanted)
    if exercise is None or exercise.author_id != account.id:
        raise NotFound(UNKNOWN)
    return exercise


def is_current_draft_published(exercise: AuthoredExercise) -> bool:
    """Whether the current version is what the author has saved last."""
    return exercise.number > 0 and (exercise.trial or {}).get("published_digest") == exercise.digest


def read_draft(exercise: AuthoredExercise) -> ExerciseDraft:
    return ExerciseDraft.from_data(exercise.draft)


def delete_exercise(db: Session, exercise: AuthoredExercise) -> None:
    """Delete an exercise that was never published. Raises Conflict for another one."""
    if exercise.number:
        raise Conflict(PUBLISHED)
    db.delete(exercise)
    db.flush()


def change_sharing(exercise: AuthoredExercise, action: str) -> None:
    """Change who may copy an exercise, by its code or in the bank, and whether classes find it in their module."""
    if action in {SHARE, WITHDRAW}:
        exercise.share_code = (exercise.share_code or draw_share_code(SHARE_CODE_LENGTH)) if action == SHARE else None
    elif action in {TO_BANK, FROM_BANK}:
        exercise.in_bank = action == TO_BANK and exercise.number > 0
    elif action in {TO_CLASSES, FROM_CLASSES}:
        exercise.for_classes = action == TO_CLASSES and exercise.number > 0


def find_exercise_by_share_code(db: Session, code: str) -> AuthoredExercise:
    """Return the exercise that bears a code. Raises NotFound."""
    found = repository.find_by_share_code(db, code.strip().lower()[:SHARE_CODE_LENGTH]) if code.strip() else None
    if found is None:
        raise NotFound(UNKNOWN_CODE)
    return found


def find_exercise_in_bank(db: Session, exercise_id: str) -> AuthoredExercise:
    """Return an exercise of the bank. Raises NotFound."""
    found = repository.find_exercise(db, parse_uuid(exercise_id, UNKNOWN))
    if found is None or not found.in_bank:
        raise NotFound(UNKNOWN)
    return found


def search_exercises(exercises: Sequence[AuthoredExercise], query: str) -> Sequence[AuthoredExercise]:
    """Return the exercises whose title, summary, level, themes or mistakes hold every word of a query."""
    words = unaccented(query).split()

    def has_all(text: str) -> bool:
        return all(word in text for word in words)

    return [exercise for exercise in exercises if has_all(_searched_text(exercise))]


def _searched_text(exercise: AuthoredExercise) -> str:
    draft = read_draft(exercise)
    parts = [draft.title, draft.summary, draft.level, draft.themes, *(mistake.title for mistake in draft.mistakes)]
    return unaccented(" ".join(parts))


def content_to_archive(exercise: AuthoredExercise) -> tuple[str, Mapping[str, Any]]:
    """Return the name and the content of the archive: the draft as it was last tried. Raises Conflict before that."""
    completed = (exercise.trial or {}).get("completed")
    if completed is None:
        raise Conflict(NOT_TRIED)
    return exercise.slug or "exercice", completed


def add_mistakes(draft: ExerciseDraft, changes: Sequence[TriedChange]) -> ExerciseDraft:
    """Return the draft with more mistakes: the solution so changed, with words to make better, which give nothing
    away."""
    mistakes = list(draft.mistakes)
    for change in changes:
        words = title_for_operator(change.operator)
        titles = {mistake.title for mistake in mistakes}
        numbered = (f"{words} ({number})" for number in range(2, MAX_MISTAKES + 2))
        title = next(title for title in (words, *numbered) if title not in titles)
        mistakes.append(MistakeDraft(title, explanation_for_operator(change.operator), program=change.program))
    return replace(draft, mistakes=tuple(mistakes))


def add_cases(draft: ExerciseDraft, report: TrialReport, picked: Collection[str]) -> ExerciseDraft:
    """Return the draft with those picked of the inputs that show what no case refuses: mistakes, and survivors.

    Raises Invalid where none is picked.
    """
    checks = list(draft.checks)
    shown: tuple[TriedMistake | TriedChange, ...] = (*report.mistakes, *report.proven_survivors)
    chosen = [each for each in shown if each.case and each.case in picked]
    require_valid_picks(picked, chosen)
    for change in chosen:
        at = change.check if change.check < len(checks) else 0
        known = {case.call.strip() for case in checks[at].cases}
        if change.case not in known and len(checks[at].cases) < MAX_CASES:
            checks[at] = replace(checks[at], cases=(*checks[at].nonempty_cases, CaseDraft(change.case)))
    return replace(draft, checks=tuple(checks))


def require_valid_picks(picked: Collection[str], found: Collection[object], nothing: str = NOTHING_PICKED) -> None:
    """Raise Invalid in the words `nothing` where nothing is picked, or where the trial no longer proposes what is."""
    if not found:
        raise Invalid(OUT_OF_DATE if picked else nothing)


def expect_exception(draft: ExerciseDraft, report: TrialReport, check: int, case: int) -> ExerciseDraft:
    """Return the draft in which the exception that the solution raised in a case is what the case must give."""
    tried = next((each for each in report.cases if (each.check, each.case) == (check, case) and each.raised), None)
    checks = list(draft.checks)
    if tried is None or check >= len(checks) or case >= len(checks[check].nonempty_cases):
        return draft
    cases = list(checks[check].nonempty_cases)
    cases[case] = replace(cases[case], expected=tried.raised)
    checks[check] = replace(checks[check], cases=tuple(cases))
    return replace(draft, checks=tuple(checks))


def remove_part(draft: ExerciseDraft, part: str, at: int) -> ExerciseDraft:
    """Return the draft without one of its `part`s, "checks" or "mistakes"; the first check stays."""
    if part == "mistakes":
        return replace(draft, mistakes=(*draft.mistakes[:at], *draft.mistakes[at + 1 :]))
    return replace(draft, checks=(*draft.checks[:at], *draft.checks[at + 1 :])) if at else draft


def list_exercises_proposed_to_account(db: Session, account: Account | None, module: str) -> Sequence[str]:
    """Return the ids of the exercises of a module that teachers propose to the classes of an account."""
    if account is None:
        return ()
    return [f"{module}/{slug}" for slug in repository.list_exercises_proposed_to_account(db, account.id, module)]


def list_exercises_of_class_teachers(db: Session, school_class: SchoolClass) -> Mapping[str, str]:
    """Return the titles of the exercises that the teachers of a class have published for its module, by id."""
    rows = repository.list_exercises_published_by_teachers(db, school_class.id, school_class.module)
    return {f"{school_class.module}/{slug}": draft.get("title") or slug for slug, draft in rows}


def _token_bucket_key(account: Account) -> str:
    return f"studio:{account.id}"
