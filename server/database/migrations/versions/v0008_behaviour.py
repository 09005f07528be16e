"""Groups of programs that answer alike, and the names that teachers give them"""

import sqlalchemy as sa
from alembic import op

revision = "0008"
down_revision = "0007"
branch_labels = None
depends_on = None

TIME = sa.DateTime(timezone=True)


def _to(column: str, table: str, of: str, rule: str) -> sa.ForeignKeyConstraint:
    name = op.f(f"fk_{of}_{column}_{table}")
    return sa.ForeignKeyConstraint([column], [f"{table}.id"], name=name, ondelete=rule)


def upgrade() -> None:
    op.create_index(op.f("ix_grading_finished_at"), "grading", ["finished_at"])
    op.create_table(
        "behaviour_group",
        sa.Column("id", sa.String(length=16), nullable=False),
        sa.Column("exercise", sa.String(length=200), nullable=False),
        sa.Column("exercise_version", sa.String(length=64), nullable=False),
        sa.Column("structure", sa.String(length=64), nullable=False),
        sa.Column("projection", sa.Double(), nullable=False),
        sa.Column("answers", sa.LargeBinary(), nullable=False),
        sa.Column("functions", sa.JSON(), nullable=False),
        sa.Column("example", sa.JSON(), nullable=True),
        sa.Column("created_at", TIME, nullable=False),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_behaviour_group")),
    )
    op.create_index(
        "ix_behaviour_group_alike", "behaviour_group", ["exercise", "exercise_version", "structure", "projection"]
    )
    op.create_table(
        "fingerprint",
        sa.Column("grading_id", sa.Uuid(), nullable=False),
        sa.Column("group_id", sa.String(length=16), nullable=True),
        sa.Column("made_at", TIME, nullable=False),
        _to("grading_id", "grading", "fingerprint", "CASCADE"),
        _to("group_id", "behaviour_group", "fingerprint", "CASCADE"),
        sa.PrimaryKeyConstraint("grading_id", name=op.f("pk_fingerprint")),
    )
    op.create_index(op.f("ix_fingerprint_group_id"), "fingerprint", ["group_id"])
    op.create_table(
        "behaviour_name",
        sa.Column("class_id", sa.Uuid(), nullable=False),
        sa.Column("group_id", sa.String(length=16), nullable=False),
        sa.Column("title", sa.String(length=200), nullable=False),
        sa.Column("explanation", sa.Text(), nullable=False),
        sa.Column("question", sa.Text(), nullable=False),
        sa.Column("named_by", sa.Uuid(), nullable=True),
        sa.Column("named_at", TIME, nullable=False),
        _to("class_id", "school_class", "behaviour_name", "CASCADE"),
        _to("group_id", "behaviour_group", "behaviour_name", "CASCADE"),
        _to("named_by", "account", "behaviour_name", "SET NULL"),
        sa.PrimaryKeyConstraint("class_id", "group_id", name=op.f("pk_behaviour_name")),
    )
    op.create_index(op.f("ix_behaviour_name_group_id"), "behaviour_name", ["group_id"])
    op.create_index(op.f("ix_behaviour_name_named_by"), "behaviour_name", ["named_by"])


def downgrade() -> None:
    for table in ("behaviour_name", "fingerprint", "behaviour_group"):
        op.drop_table(table)
    op.drop_index(op.f("ix_grading_finished_at"), "grading")
