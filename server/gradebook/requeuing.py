"""Submissions that nothing grades any more, or that we have failed to grade: queued again."""

from collections.abc import Collection
from uuid import UUID

from server.base.errors import NotFound
from server.database import Database
from server.gradebook import repository
from server.submissions import repository as stored
from server.submissions.service import UNKNOWN, Submissions, parse_id

NOTHING_TO_DO = "L’essai {name} a son verdict : une recorrection, depuis la classe, le corrige à nouveau."


def requeue(database: Database, submissions: Submissions, *, failed: bool, names: Collection[str] = ()) -> list[UUID]:
    """Queues what waits without a job, with `failed` what ended as an error of ours too, or these alone; which.

    One transaction each: others write between. What fails again keeps its place in the history. Raises NotFound.
    """
    with database.read() as db:
        found = (*stored.ungraded(db), *(repository.failed(db) if failed or names else ()))
        candidates = {one.id: one.grading_id for one in found}
    chosen = list(map(parse_id, names))
    for name in sorted(set(chosen) - candidates.keys()):
        with database.read() as db:
            raise NotFound(UNKNOWN if stored.by_id(db, name) is None else NOTHING_TO_DO.format(name=name))
    return [name for name in chosen or candidates if _queued(database, submissions, name, candidates[name])]


def _queued(database: Database, submissions: Submissions, name: UUID, grading: UUID | None) -> bool:
    """False where it has been graded meanwhile, is queued already, or is gone."""
    with database.write() as db:
        row = repository.with_author(db, name)
        return row is not None and row[0].grading_id == grading and submissions.requeue(db, *row)
