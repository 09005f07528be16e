"""jobs apart from submissions, a history of gradings, where each account stands

There is no way back: a history holds more than the columns that it replaces. Keep a copy of the database instead.
"""

from collections.abc import Iterator, Sequence
from itertools import groupby
from typing import Any

import sqlalchemy as sa
from alembic import op

revision = "0003"
down_revision = "0002"
branch_labels = None
depends_on = None

CHUNK = 200
MOVED = (
    "verdict", "figures", "state", "started_at", "finished_at", "attempts",
    "lease_owner", "lease_token", "lease_until", "outcome", "score",
)  # fmt: skip
TIME = sa.DateTime(timezone=True)

submission = sa.table(
    "submission",
    sa.column("id", sa.Uuid()),
    sa.column("account_id", sa.Uuid()),
    sa.column("exercise", sa.String()),
    sa.column("seed", sa.BigInteger()),
    sa.column("state", sa.String()),
    sa.column("created_at", TIME),
    sa.column("started_at", TIME),
    sa.column("finished_at", TIME),
    sa.column("attempts", sa.Integer()),
    sa.column("lease_owner", sa.String()),
    sa.column("lease_token", sa.Uuid()),
    sa.column("lease_until", TIME),
    sa.column("outcome", sa.String()),
    sa.column("score", sa.Double()),
    sa.column("verdict", sa.JSON()),
    sa.column("figures", sa.JSON()),
    sa.column("grading_id", sa.Uuid()),
)


def upgrade() -> None:
    job, grading, standing = _job(), _grading(), _standing()
    _point_at_gradings()
    _copy_jobs(job)
    _copy_gradings(grading)
    _sum_up(grading, standing)
    _drop_what_has_moved()
    _deal()


def downgrade() -> None:
    raise NotImplementedError("the history of gradings would be lost: go back to a copy of the database")


def _job() -> sa.Table:
    table = op.create_table(
        "job",
        sa.Column("id", sa.Uuid(), nullable=False),
        sa.Column("kind", sa.String(length=32), nullable=False),
        sa.Column("key", sa.String(length=200), nullable=False),
        sa.Column("payload", sa.JSON(), nullable=False),
        sa.Column("priority", sa.Integer(), nullable=False),
        sa.Column("created_at", TIME, nullable=False),
        sa.Column("started_at", TIME, nullable=True),
        sa.Column("tries", sa.Integer(), nullable=False),
        sa.Column("lease_owner", sa.String(length=300), nullable=True),
        sa.Column("lease_token", sa.Uuid(), nullable=True),
        sa.Column("lease_until", TIME, nullable=True),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_job")),
        sa.UniqueConstraint("kind", "key", name=op.f("uq_job_kind_key")),
    )
    op.create_index("ix_job_claim", "job", ["priority", "created_at", "id"])
    return table


def _grading() -> sa.Table:
    table = op.create_table(
        "grading",
        sa.Column("id", sa.Uuid(), nullable=False),
        sa.Column("submission_id", sa.Uuid(), nullable=False),
        sa.Column("exercise_version", sa.String(length=64), nullable=False),
        sa.Column("outcome", sa.String(length=32), nullable=False),
        sa.Column("score", sa.Double(), nullable=True),
        sa.Column("diagnosis", sa.String(length=200), nullable=True),
        sa.Column("seed", sa.BigInteger(), nullable=False),
        sa.Column("started_at", TIME, nullable=False),
        sa.Column("finished_at", TIME, nullable=False),
        sa.Column("checks_ms", sa.Double(), nullable=True),
        sa.Column("diagnosis_ms", sa.Double(), nullable=True),
        sa.Column("total_ms", sa.Double(), nullable=True),
        sa.Column("verdict", sa.JSON(), nullable=False),
        sa.Column("figures", sa.JSON(), nullable=False),
        sa.ForeignKeyConstraint(
            ["submission_id"], ["submission.id"], name=op.f("fk_grading_submission_id_submission"), ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_grading")),
    )
    op.create_index("ix_grading_submission_id", "grading", ["submission_id"])
    return table


def _standing() -> sa.Table:
    return op.create_table(
        "standing",
        sa.Column("account_id", sa.Uuid(), nullable=False),
        sa.Column("exercise", sa.String(length=200), nullable=False),
        sa.Column("best_score", sa.Double(), nullable=False),
        sa.Column("attempts", sa.Integer(), nullable=False),
        sa.Column("last_outcome", sa.String(length=32), nullable=False),
        sa.Column("last_diagnosis", sa.String(length=200), nullable=True),
        sa.Column("first_success_at", TIME, nullable=True),
        sa.Column("last_at", TIME, nullable=False),
        sa.ForeignKeyConstraint(
            ["account_id"], ["account.id"], name=op.f("fk_standing_account_id_account"), ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("account_id", "exercise", name=op.f("pk_standing")),
    )


def _on_sqlite() -> bool:
    return op.get_bind().dialect.name == "sqlite"


def _point_at_gradings() -> None:
    """SQLite cannot add a constraint to a table, but a column with one."""
    if _on_sqlite():
        op.execute("ALTER TABLE submission ADD COLUMN grading_id CHAR(32) REFERENCES grading (id)")
        return
    op.add_column("submission", sa.Column("grading_id", sa.Uuid(), nullable=True))
    op.create_foreign_key("fk_submission_grading_id_grading", "submission", "grading", ["grading_id"], ["id"])


def _copy_jobs(job: sa.Table) -> None:
    """What waits or runs: a worker that grades meanwhile keeps its lease."""
    names = ("id", "created_at", "started_at", "attempts", "lease_owner", "lease_token", "lease_until", "state")
    for rows in _chunks(sa.select(*(submission.c[name] for name in names)).where(submission.c.state != "done")):
        op.bulk_insert(job, [_job_of(row) for row in rows])


def _job_of(row: sa.RowMapping) -> dict[str, Any]:
    kept = ("id", "created_at", "lease_owner", "lease_token", "lease_until")
    return {
        **{name: row[name] for name in kept},
        "kind": "grade",
        "key": str(row["id"]),
        "payload": {},
        "priority": 0,
        "started_at": row["started_at"] if row["state"] == "running" else None,
        "tries": row["attempts"],
    }


def _copy_gradings(grading: sa.Table) -> None:
    """A submission's first grading has the submission's own name."""
    names = ("id", "seed", "created_at", "started_at", "finished_at", "outcome", "score", "verdict", "figures")
    for rows in _chunks(sa.select(*(submission.c[name] for name in names)).where(submission.c.state == "done")):
        op.bulk_insert(grading, [_grading_of(row) for row in rows])
    op.execute(sa.update(submission).where(submission.c.state == "done").values(grading_id=submission.c.id))


def _grading_of(row: sa.RowMapping) -> dict[str, Any]:
    verdict = row["verdict"]
    timings = verdict["timings"]
    started_at = row["started_at"] or row["created_at"]
    return {
        "id": row["id"],
        "submission_id": row["id"],
        "exercise_version": verdict["exercise_version"],
        "outcome": row["outcome"],
        "score": row["score"],
        "diagnosis": verdict["diagnosis"]["id"] if verdict["diagnosis"] else None,
        "seed": row["seed"],
        "started_at": started_at,
        "finished_at": row["finished_at"] or started_at,
        **{name: timings.get(name) for name in ("checks_ms", "diagnosis_ms", "total_ms")},
        "verdict": verdict,
        "figures": row["figures"] or {},
    }


def _chunks(query: sa.Select[Any]) -> Iterator[Sequence[sa.RowMapping]]:
    """The rows of a query on submissions, a few at a time: their verdicts need not be in memory together."""
    ordered = query.order_by(submission.c.id).limit(CHUNK)
    rows = op.get_bind().execute(ordered).mappings().all()
    while rows:
        yield rows
        rows = op.get_bind().execute(ordered.where(submission.c.id > rows[-1]["id"])).mappings().all()


def _sum_up(grading: sa.Table, standing: sa.Table) -> None:
    key = (submission.c.account_id, submission.c.exercise)
    query = (
        sa.select(*key, submission.c.created_at, submission.c.outcome, submission.c.score, grading.c.diagnosis)
        .join_from(submission, grading, grading.c.id == submission.c.grading_id)
        .where(submission.c.outcome != "internal_error")
        .order_by(*key, submission.c.created_at, submission.c.id)
    )
    counted = op.get_bind().execute(query).mappings().all()
    groups = groupby(counted, key=lambda row: (row["account_id"], row["exercise"]))
    sums = [_standing_of(account_id, exercise, list(rows)) for (account_id, exercise), rows in groups]
    if sums:
        op.bulk_insert(standing, sums)


def _standing_of(account_id: Any, exercise: str, rows: list[sa.RowMapping]) -> dict[str, Any]:
    """Of attempts in the order in which they were sent."""
    last = rows[-1]
    return {
        "account_id": account_id,
        "exercise": exercise,
        "best_score": max(row["score"] for row in rows),
        "attempts": len(rows),
        "last_outcome": last["outcome"],
        "last_diagnosis": last["diagnosis"],
        "first_success_at": next((row["created_at"] for row in rows if row["outcome"] == "ok"), None),
        "last_at": last["created_at"],
    }


def _drop_what_has_moved() -> None:
    """Column by column: SQLite makes a table anew by dropping the old one, and the gradings with it."""
    op.drop_index("ix_submission_queue", "submission")
    for name in MOVED:
        op.execute(f"ALTER TABLE submission DROP COLUMN {name}")
    waiting = sa.text("grading_id IS NULL")
    op.create_index(
        "ix_submission_waiting",
        "submission",
        ["account_id", "exercise"],
        sqlite_where=waiting,
        postgresql_where=waiting,
    )


def _deal() -> None:
    """The table `draw` under its new name, constraints and all: nothing refers to it."""
    names = ("account_id", "exercise", "seed", "created_at")
    op.create_table(
        "deal",
        sa.Column("account_id", sa.Uuid(), nullable=False),
        sa.Column("exercise", sa.String(length=200), nullable=False),
        sa.Column("seed", sa.BigInteger(), nullable=False),
        sa.Column("created_at", TIME, nullable=False),
        sa.ForeignKeyConstraint(
            ["account_id"], ["account.id"], name=op.f("fk_deal_account_id_account"), ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("account_id", "exercise", name=op.f("pk_deal")),
    )
    columns = ", ".join(names)
    op.execute(f"INSERT INTO deal ({columns}) SELECT {columns} FROM draw")
    op.drop_table("draw")
