"""Marks that say what they are: scopes of overrides, states, rules of the mean, columns of teachers"""

import sqlalchemy as sa
from alembic import op

revision = "0025"
down_revision = "0024"
branch_labels = None
depends_on = None

TIME = sa.DateTime(timezone=True)
ACTIVE = "withdrawn_at IS NULL"
BY_NAME = "uq_mark_override_active"
SCOPE_KEY = "fk_mark_override_assignment_id_assignment"
BY_ASSIGNMENT = "uq_mark_override_active_assignment"


def _key(of: str, column: str, table: str, rule: str = "CASCADE") -> sa.ForeignKeyConstraint:
    return sa.ForeignKeyConstraint([column], [f"{table}.id"], name=op.f(f"fk_{of}_{column}_{table}"), ondelete=rule)


def _unique(name: str, table: str, columns: list[str], condition: str) -> None:
    where = sa.text(condition)
    op.create_index(name, table, columns, unique=True, sqlite_where=where, postgresql_where=where)


def upgrade() -> None:
    op.drop_index(BY_NAME, "mark_override")
    with op.batch_alter_table("mark_override") as overrides:
        overrides.add_column(sa.Column("assignment_id", sa.Uuid(), nullable=True))
        overrides.create_foreign_key(SCOPE_KEY, "assignment", ["assignment_id"], ["id"], ondelete="CASCADE")
    op.create_index(op.f("ix_mark_override_assignment_id"), "mark_override", ["assignment_id"])
    # What was set before holds everywhere, as it did.
    _unique(BY_NAME, "mark_override", ["class_id", "account_id", "exercise"], f"{ACTIVE} AND assignment_id IS NULL")
    _unique(
        BY_ASSIGNMENT,
        "mark_override",
        ["assignment_id", "account_id", "exercise"],
        f"{ACTIVE} AND assignment_id IS NOT NULL",
    )

    op.create_table(
        "mark_decision",
        sa.Column("id", sa.Uuid(), nullable=False),
        sa.Column("assignment_id", sa.Uuid(), nullable=False),
        sa.Column("account_id", sa.Uuid(), nullable=False),
        sa.Column("state", sa.String(length=16), nullable=False),
        sa.Column("reason", sa.Text(), nullable=False),
        sa.Column("by", sa.Uuid(), nullable=True),
        sa.Column("at", TIME, nullable=False),
        sa.Column("withdrawn_at", TIME, nullable=True),
        _key("mark_decision", "assignment_id", "assignment"),
        _key("mark_decision", "account_id", "account"),
        _key("mark_decision", "by", "account", "SET NULL"),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_mark_decision")),
    )
    op.create_index(op.f("ix_mark_decision_account_id"), "mark_decision", ["account_id"])
    op.create_index(op.f("ix_mark_decision_by"), "mark_decision", ["by"])
    _unique("uq_mark_decision_active", "mark_decision", ["assignment_id", "account_id"], ACTIVE)

    op.create_table(
        "marking_policy",
        sa.Column("class_id", sa.Uuid(), nullable=False),
        sa.Column("not_handed_in", sa.String(length=8), nullable=False),
        sa.Column("late_refused", sa.String(length=8), nullable=False),
        sa.Column("absent", sa.String(length=8), nullable=False),
        sa.Column("unanswered", sa.String(length=8), nullable=False),
        sa.Column("chosen_at", TIME, nullable=True),
        sa.Column("version", sa.Integer(), nullable=False),
        _key("marking_policy", "class_id", "school_class"),
        sa.PrimaryKeyConstraint("class_id", name=op.f("pk_marking_policy")),
    )
    # A class that was made before keeps its means until a teacher chooses: what was not handed in counted 0.
    op.execute(
        "INSERT INTO marking_policy (class_id, not_handed_in, late_refused, absent, unanswered, version) "
        "SELECT id, 'zero', 'zero', 'zero', 'zero', 1 FROM school_class"
    )

    op.create_table(
        "manual_column",
        sa.Column("id", sa.Uuid(), nullable=False),
        sa.Column("class_id", sa.Uuid(), nullable=False),
        sa.Column("title", sa.String(length=100), nullable=False),
        sa.Column("out_of", sa.Double(), nullable=False),
        sa.Column("taken_on", sa.Date(), nullable=True),
        sa.Column("weight", sa.Double(), nullable=False),
        sa.Column("bonus", sa.Boolean(), nullable=False),
        sa.Column("position", sa.Integer(), nullable=False),
        sa.Column("published_at", TIME, nullable=True),
        sa.Column("created_by", sa.Uuid(), nullable=True),
        sa.Column("created_at", TIME, nullable=False),
        sa.Column("deleted_at", TIME, nullable=True),
        sa.Column("version", sa.Integer(), nullable=False),
        _key("manual_column", "class_id", "school_class"),
        _key("manual_column", "created_by", "account", "SET NULL"),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_manual_column")),
    )
    op.create_index(op.f("ix_manual_column_class_id"), "manual_column", ["class_id"])
    op.create_index(op.f("ix_manual_column_created_by"), "manual_column", ["created_by"])

    op.create_table(
        "manual_mark",
        sa.Column("column_id", sa.Uuid(), nullable=False),
        sa.Column("account_id", sa.Uuid(), nullable=False),
        sa.Column("points", sa.Double(), nullable=True),
        sa.Column("state", sa.String(length=16), nullable=True),
        sa.Column("comment", sa.Text(), nullable=False),
        sa.Column("by", sa.Uuid(), nullable=True),
        sa.Column("at", TIME, nullable=False),
        sa.Column("version", sa.Integer(), nullable=False),
        _key("manual_mark", "column_id", "manual_column"),
        _key("manual_mark", "account_id", "account"),
        _key("manual_mark", "by", "account", "SET NULL"),
        sa.PrimaryKeyConstraint("column_id", "account_id", name=op.f("pk_manual_mark")),
    )
    op.create_index(op.f("ix_manual_mark_account_id"), "manual_mark", ["account_id"])
    op.create_index(op.f("ix_manual_mark_by"), "manual_mark", ["by"])


def downgrade() -> None:
    for table in ("manual_mark", "manual_column", "marking_policy", "mark_decision"):
        op.drop_table(table)
    op.execute("DELETE FROM mark_override WHERE assignment_id IS NOT NULL")
    op.drop_index(BY_ASSIGNMENT, "mark_override")
    op.drop_index(BY_NAME, "mark_override")
    op.drop_index(op.f("ix_mark_override_assignment_id"), "mark_override")
    with op.batch_alter_table("mark_override") as overrides:
        overrides.drop_constraint(SCOPE_KEY, type_="foreignkey")
        overrides.drop_column("assignment_id")
    _unique(BY_NAME, "mark_override", ["class_id", "account_id", "exercise"], ACTIVE)
