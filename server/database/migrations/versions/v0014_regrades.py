"""Regrades: what was sent is graded anew, and counts once that is applied"""

import sqlalchemy as sa
from alembic import op

revision = "0014"
down_revision = "0012"
branch_labels = None
depends_on = None

TIME = sa.DateTime(timezone=True)
WAITS = sa.text("after_id IS NULL")


def _to(column: str, table: str, of: str, rule: str) -> sa.ForeignKeyConstraint:
    name = op.f(f"fk_{of}_{column}_{table}")
    return sa.ForeignKeyConstraint([column], [f"{table}.id"], name=name, ondelete=rule)


def upgrade() -> None:
    op.create_table(
        "regrade",
        sa.Column("id", sa.Uuid(), nullable=False),
        sa.Column("class_id", sa.Uuid(), nullable=False),
        sa.Column("exercise", sa.String(length=200), nullable=False),
        sa.Column("policy", sa.String(length=16), nullable=False),
        sa.Column("scope", sa.String(length=16), nullable=False),
        sa.Column("assignment_id", sa.Uuid(), nullable=True),
        sa.Column("student_id", sa.Uuid(), nullable=True),
        sa.Column("created_by", sa.Uuid(), nullable=True),
        sa.Column("created_at", TIME, nullable=False),
        sa.Column("stopped_at", TIME, nullable=True),
        sa.Column("applied_at", TIME, nullable=True),
        sa.Column("undone_at", TIME, nullable=True),
        _to("class_id", "school_class", "regrade", "CASCADE"),
        _to("assignment_id", "assignment", "regrade", "SET NULL"),
        _to("student_id", "account", "regrade", "SET NULL"),
        _to("created_by", "account", "regrade", "SET NULL"),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_regrade")),
    )
    for column in ("class_id", "assignment_id", "student_id", "created_by"):
        op.create_index(op.f(f"ix_regrade_{column}"), "regrade", [column])
    op.create_table(
        "regrade_item",
        sa.Column("id", sa.Uuid(), nullable=False),
        sa.Column("regrade_id", sa.Uuid(), nullable=False),
        sa.Column("position", sa.Integer(), nullable=False),
        sa.Column("counting", sa.Boolean(), nullable=False),
        sa.Column("submission_id", sa.Uuid(), nullable=False),
        sa.Column("before_id", sa.Uuid(), nullable=False),
        sa.Column("after_id", sa.Uuid(), nullable=True),
        sa.Column("why", sa.JSON(), nullable=False),
        sa.Column("moved", sa.Boolean(), nullable=False),
        _to("regrade_id", "regrade", "regrade_item", "CASCADE"),
        _to("submission_id", "submission", "regrade_item", "CASCADE"),
        _to("before_id", "grading", "regrade_item", "CASCADE"),
        _to("after_id", "grading", "regrade_item", "CASCADE"),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_regrade_item")),
    )
    op.create_index("ix_regrade_item_regrade_id", "regrade_item", ["regrade_id"])
    for column in ("submission_id", "before_id", "after_id"):
        op.create_index(op.f(f"ix_regrade_item_{column}"), "regrade_item", [column])
    op.create_index(
        "ix_regrade_item_waiting",
        "regrade_item",
        ["regrade_id", "position"],
        sqlite_where=WAITS,
        postgresql_where=WAITS,
    )


def downgrade() -> None:
    for table in ("regrade_item", "regrade"):
        op.drop_table(table)
