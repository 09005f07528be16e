"""The variant of an account: the seed of the random data of one exercise, which stays the same whatever it submits."""

import secrets
from uuid import UUID

from sqlalchemy.orm import Session

from server.course.models import SEED_BITS
from server.database import Database
from server.identity.models import Account
from server.submissions import repository


def get_or_create_seed(db: Session, account: Account, exercise_id: str) -> int:
    """Return the seed of this account's variant; create it in this writing transaction where there is none."""
    repository.insert_seed_once(db, account.id, exercise_id, secrets.randbits(SEED_BITS))
    return repository.load_existing_seed(db, account.id, exercise_id)


def find_seed(db: Session, account: Account, exercise_id: str) -> int | None:
    """Return the seed of this account's variant, if there is one."""
    return repository.find_seed(db, account.id, exercise_id)


def ensure_seed_while_reading(db: Session, database: Database, account: Account, exercise_id: str) -> int:
    """Return the seed for a caller that only reads, through `db`.

    A missing seed is written in a transaction of its own, which later reads of `db` may not see.
    """
    seed = find_seed(db, account, exercise_id)
    if seed is not None:
        return seed
    with database.write() as writing:
        return get_or_create_seed(writing, account, exercise_id)


def ensure_seed(database: Database, account: Account, exercise_id: str) -> int:
    """Return the seed, for a caller that reads nothing else."""
    with database.read() as db:
        return ensure_seed_while_reading(db, database, account, exercise_id)


def adopt_guest_variants(db: Session, guest_id: UUID, account_id: UUID) -> None:
    """Give an account the variants of a guest; where both have one, the account keeps its own."""
    repository.move_variants(db, guest_id, account_id)
