"""Assignments, exemptions, and the log of what was changed in a class"""

import sqlalchemy as sa
from alembic import op

revision = "0007"
down_revision = "0006"
branch_labels = None
depends_on = None

TIME = sa.DateTime(timezone=True)


def _to(column: str, table: str, of: str, rule: str) -> sa.ForeignKeyConstraint:
    name = op.f(f"fk_{of}_{column}_{table}")
    return sa.ForeignKeyConstraint([column], [f"{table}.id"], name=name, ondelete=rule)


def upgrade() -> None:
    op.create_table(
        "assignment",
        sa.Column("id", sa.Uuid(), nullable=False),
        sa.Column("class_id", sa.Uuid(), nullable=False),
        sa.Column("title", sa.String(length=200), nullable=False),
        sa.Column("mode", sa.String(length=16), nullable=False),
        sa.Column("opens_at", TIME, nullable=False),
        sa.Column("due_at", TIME, nullable=True),
        sa.Column("closes_at", TIME, nullable=True),
        sa.Column("late", sa.String(length=16), nullable=False),
        sa.Column("late_per_day", sa.Double(), nullable=True),
        sa.Column("counts", sa.String(length=16), nullable=False),
        sa.Column("weight", sa.Double(), nullable=False),
        sa.Column("hints", sa.String(length=16), nullable=False),
        sa.Column("diagnosis", sa.String(length=16), nullable=False),
        sa.Column("solution", sa.String(length=16), nullable=False),
        sa.Column("duration_minutes", sa.Integer(), nullable=True),
        sa.Column("released_at", TIME, nullable=True),
        sa.Column("created_by", sa.Uuid(), nullable=True),
        sa.Column("created_at", TIME, nullable=False),
        _to("class_id", "school_class", "assignment", "CASCADE"),
        _to("created_by", "account", "assignment", "SET NULL"),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_assignment")),
    )
    op.create_index(op.f("ix_assignment_class_id"), "assignment", ["class_id"])
    op.create_table(
        "assigned_exercise",
        sa.Column("assignment_id", sa.Uuid(), nullable=False),
        sa.Column("exercise", sa.String(length=200), nullable=False),
        sa.Column("position", sa.Integer(), nullable=False),
        sa.Column("weight", sa.Double(), nullable=False),
        _to("assignment_id", "assignment", "assigned_exercise", "CASCADE"),
        sa.PrimaryKeyConstraint("assignment_id", "exercise", name=op.f("pk_assigned_exercise")),
    )
    op.create_table(
        "exemption",
        sa.Column("id", sa.Uuid(), nullable=False),
        sa.Column("assignment_id", sa.Uuid(), nullable=False),
        sa.Column("account_id", sa.Uuid(), nullable=True),
        sa.Column("label", sa.String(length=40), nullable=True),
        sa.Column("opens_at", TIME, nullable=True),
        sa.Column("due_at", TIME, nullable=True),
        sa.Column("closes_at", TIME, nullable=True),
        sa.Column("time_factor", sa.Double(), nullable=True),
        sa.Column("excused", sa.Boolean(), nullable=True),
        sa.Column("reason", sa.Text(), nullable=False),
        sa.Column("created_by", sa.Uuid(), nullable=True),
        sa.Column("created_at", TIME, nullable=False),
        sa.Column("revoked_at", TIME, nullable=True),
        sa.CheckConstraint("(account_id IS NULL) <> (label IS NULL)", name=op.f("ck_exemption_one_of")),
        _to("assignment_id", "assignment", "exemption", "CASCADE"),
        _to("account_id", "account", "exemption", "CASCADE"),
        _to("created_by", "account", "exemption", "SET NULL"),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_exemption")),
    )
    op.create_index(op.f("ix_exemption_assignment_id"), "exemption", ["assignment_id"])
    op.create_index(op.f("ix_exemption_account_id"), "exemption", ["account_id"])
    op.create_table(
        "audit_event",
        sa.Column("id", sa.Uuid(), nullable=False),
        sa.Column("class_id", sa.Uuid(), nullable=False),
        sa.Column("at", TIME, nullable=False),
        sa.Column("by", sa.Uuid(), nullable=True),
        sa.Column("what", sa.String(length=32), nullable=False),
        sa.Column("student", sa.Uuid(), nullable=True),
        sa.Column("about", sa.String(length=300), nullable=False),
        sa.Column("before", sa.JSON(), nullable=False),
        sa.Column("after", sa.JSON(), nullable=False),
        sa.Column("reason", sa.Text(), nullable=False),
        _to("class_id", "school_class", "audit_event", "CASCADE"),
        _to("by", "account", "audit_event", "SET NULL"),
        _to("student", "account", "audit_event", "SET NULL"),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_audit_event")),
    )
    op.create_index("ix_audit_event_class_id_at", "audit_event", ["class_id", "at"])
    op.create_index(op.f("ix_audit_event_by"), "audit_event", ["by"])
    op.create_index(op.f("ix_audit_event_student"), "audit_event", ["student"])


def downgrade() -> None:
    for table in ("audit_event", "exemption", "assigned_exercise", "assignment"):
        op.drop_table(table)
