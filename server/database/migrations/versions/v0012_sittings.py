"""Tests: who sits one, and what they have saved in it"""

import sqlalchemy as sa
from alembic import op

revision = "0012"
down_revision = "0011"
branch_labels = None
depends_on = None

TIME = sa.DateTime(timezone=True)


def _to(column: str, table: str, of: str) -> sa.ForeignKeyConstraint:
    return sa.ForeignKeyConstraint(
        [column], [f"{table}.id"], name=op.f(f"fk_{of}_{column}_{table}"), ondelete="CASCADE"
    )


def upgrade() -> None:
    op.create_table(
        "sitting",
        sa.Column("assignment_id", sa.Uuid(), nullable=False),
        sa.Column("account_id", sa.Uuid(), nullable=False),
        sa.Column("began_at", TIME, nullable=False),
        sa.Column("handed_in_at", TIME, nullable=True),
        sa.Column("ended_by", sa.String(length=16), nullable=True),
        _to("assignment_id", "assignment", "sitting"),
        _to("account_id", "account", "sitting"),
        sa.PrimaryKeyConstraint("assignment_id", "account_id", name=op.f("pk_sitting")),
    )
    op.create_index(op.f("ix_sitting_account_id"), "sitting", ["account_id"])
    op.create_table(
        "saved_work",
        sa.Column("assignment_id", sa.Uuid(), nullable=False),
        sa.Column("account_id", sa.Uuid(), nullable=False),
        sa.Column("exercise", sa.String(length=200), nullable=False),
        sa.Column("source", sa.LargeBinary(), nullable=False),
        sa.Column("saved_at", TIME, nullable=False),
        _to("assignment_id", "assignment", "saved_work"),
        _to("account_id", "account", "saved_work"),
        sa.PrimaryKeyConstraint("assignment_id", "account_id", "exercise", name=op.f("pk_saved_work")),
    )
    op.create_index(op.f("ix_saved_work_account_id"), "saved_work", ["account_id"])


def downgrade() -> None:
    op.drop_table("saved_work")
    op.drop_table("sitting")
