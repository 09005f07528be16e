"""Marks that teachers set in place of automatic ones"""

import sqlalchemy as sa
from alembic import op

revision = "0011"
down_revision = "0009"
branch_labels = None
depends_on = None

TIME = sa.DateTime(timezone=True)


def _to(column: str, table: str, rule: str) -> sa.ForeignKeyConstraint:
    name = op.f(f"fk_mark_override_{column}_{table}")
    return sa.ForeignKeyConstraint([column], [f"{table}.id"], name=name, ondelete=rule)


def upgrade() -> None:
    op.create_table(
        "mark_override",
        sa.Column("id", sa.Uuid(), nullable=False),
        sa.Column("class_id", sa.Uuid(), nullable=False),
        sa.Column("account_id", sa.Uuid(), nullable=False),
        sa.Column("exercise", sa.String(length=200), nullable=False),
        sa.Column("points", sa.Double(), nullable=True),
        sa.Column("excused", sa.Boolean(), nullable=False),
        sa.Column("reason", sa.Text(), nullable=False),
        sa.Column("based_on", sa.JSON(), nullable=False),
        sa.Column("by", sa.Uuid(), nullable=True),
        sa.Column("at", TIME, nullable=False),
        sa.Column("withdrawn_at", TIME, nullable=True),
        _to("class_id", "school_class", "CASCADE"),
        _to("account_id", "account", "CASCADE"),
        _to("by", "account", "SET NULL"),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_mark_override")),
    )
    op.create_index(op.f("ix_mark_override_account_id"), "mark_override", ["account_id"])
    op.create_index(op.f("ix_mark_override_by"), "mark_override", ["by"])
    in_force = sa.text("withdrawn_at IS NULL")
    op.create_index(
        "uq_mark_override_active",
        "mark_override",
        ["class_id", "account_id", "exercise"],
        unique=True,
        sqlite_where=in_force,
        postgresql_where=in_force,
    )


def downgrade() -> None:
    op.drop_table("mark_override")
