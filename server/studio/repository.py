"""Queries on exercises that teachers write, and on their versions."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from uuid import UUID

from sqlalchemy import Row, delete, func, select, tuple_
from sqlalchemy.orm import Session, aliased

from server.classes.models import ClassRole, Membership, SchoolClass, Status
from server.studio.models import AuthoredExercise, ExerciseVersion


def find_exercise(db: Session, exercise_id: UUID) -> AuthoredExercise | None:
    return db.get(AuthoredExercise, exercise_id)


def lock_exercise(db: Session, exercise_id: UUID) -> AuthoredExercise | None:
    """Return an exercise, locked until the commit."""
    query = select(AuthoredExercise).where(AuthoredExercise.id == exercise_id).with_for_update()
    return db.execute(query.execution_options(populate_existing=True)).scalar_one_or_none()


def list_exercises(db: Session, author_id: UUID) -> Sequence[AuthoredExercise]:
    """Return the exercises of an author, the one saved last first."""
    query = select(AuthoredExercise).where(AuthoredExercise.author_id == author_id)
    return db.execute(query.order_by(AuthoredExercise.saved_at.desc(), AuthoredExercise.id)).scalars().all()


def count_exercises(db: Session, author_id: UUID) -> int:
    query = select(func.count()).select_from(AuthoredExercise).where(AuthoredExercise.author_id == author_id)
    return db.execute(query).scalar_one()


def find_by_share_code(db: Session, code: str) -> AuthoredExercise | None:
    return db.execute(select(AuthoredExercise).where(AuthoredExercise.share_code == code)).scalar_one_or_none()


def list_shared_bank(db: Session) -> Sequence[AuthoredExercise]:
    """Return the published exercises that their authors lend to all teachers of this server, the last first."""
    query = select(AuthoredExercise).where(AuthoredExercise.in_bank, AuthoredExercise.number > 0)
    return db.execute(query.order_by(AuthoredExercise.saved_at.desc(), AuthoredExercise.id).limit(500)).scalars().all()


def find_current_number(db: Session, module: str, slug: str) -> Row[UUID, int] | None:
    """Return the id and the number of the current version of a published exercise."""
    query = select(AuthoredExercise.id, AuthoredExercise.number).where(
        AuthoredExercise.module == module, AuthoredExercise.slug == slug, AuthoredExercise.number > 0
    )
    return db.execute(query).one_or_none()


def list_current_versions(db: Session, names: Collection[str]) -> dict[str, str]:
    """Return the current versions of those of these exercises ("l20/…") that are authored and published, by name."""
    pairs = [tuple(name.split("/", 1)) for name in names if "/" in name]
    query = (
        select(AuthoredExercise.module, AuthoredExercise.slug, ExerciseVersion.version)
        .join(
            ExerciseVersion,
            (ExerciseVersion.exercise_id == AuthoredExercise.id) & (ExerciseVersion.number == AuthoredExercise.number),
        )
        .where(tuple_(AuthoredExercise.module, AuthoredExercise.slug).in_(pairs))
    )
    return {f"{module}/{slug}": version for module, slug, version in db.execute(query)}


def find_version(db: Session, exercise_id: UUID, number: int) -> ExerciseVersion | None:
    return db.get(ExerciseVersion, (exercise_id, number))


def list_versions(db: Session, exercise_id: UUID) -> Sequence[ExerciseVersion]:
    """Return the versions of an exercise, the current one first."""
    query = select(ExerciseVersion).where(ExerciseVersion.exercise_id == exercise_id)
    return db.execute(query.order_by(ExerciseVersion.number.desc())).scalars().all()


def list_exercises_published_by_teachers(
    db: Session, class_id: UUID, module: str
) -> Sequence[Row[str, dict[str, str]]]:
    """Return slug and draft of the published exercises of a module by the teachers of a class, by slug."""
    teachers = select(Membership.account_id).where(
        Membership.class_id == class_id, Membership.role == ClassRole.teacher, Membership.status == Status.active
    )
    query = select(AuthoredExercise.slug, AuthoredExercise.draft).where(
        AuthoredExercise.module == module, AuthoredExercise.number > 0, AuthoredExercise.author_id.in_(teachers)
    )
    return db.execute(query.order_by(AuthoredExercise.slug)).all()


def list_exercises_proposed_to_account(db: Session, account_id: UUID, module: str) -> Sequence[str]:
    """Return the names of the exercises of a module that the teachers of an account's open classes propose to them."""
    own, teaching = aliased(Membership), aliased(Membership)
    query = (
        select(AuthoredExercise.slug)
        .join(teaching, teaching.account_id == AuthoredExercise.author_id)
        .join(own, own.class_id == teaching.class_id)
        .join(SchoolClass, SchoolClass.id == own.class_id)
        .where(
            own.account_id == account_id,
            own.status == Status.active,
            teaching.role == ClassRole.teacher,
            teaching.status == Status.active,
            SchoolClass.module == module,
            SchoolClass.archived_at.is_(None),
            AuthoredExercise.module == module,
            AuthoredExercise.number > 0,
            AuthoredExercise.for_classes,
        )
    )
    return [slug for slug in db.execute(query.distinct().order_by(AuthoredExercise.slug)).scalars() if slug]


def delete_abandoned_exercises(db: Session) -> None:
    """Delete what nobody can publish any more: unpublished exercises whose author is gone."""
    abandoned = AuthoredExercise.author_id.is_(None) & (AuthoredExercise.number == 0)
    db.execute(delete(AuthoredExercise).where(abandoned).execution_options(synchronize_session=False))
