"""Exercises that teachers write in the browser, and their published versions"""

import sqlalchemy as sa
from alembic import op

revision = "0039"
down_revision = "0038"
branch_labels = None
depends_on = None

TIME = sa.DateTime(timezone=True)


def upgrade() -> None:
    op.create_table(
        "authored_exercise",
        sa.Column("id", sa.Uuid(), nullable=False),
        sa.Column("author_id", sa.Uuid(), nullable=True),
        sa.Column("module", sa.String(40), nullable=False),
        sa.Column("slug", sa.String(60), nullable=True),
        sa.Column("draft", sa.JSON(), nullable=False),
        sa.Column("digest", sa.String(64), nullable=False),
        sa.Column("trial", sa.JSON(), nullable=True),
        sa.Column("wants_publication", sa.Boolean(), nullable=False),
        sa.Column("number", sa.Integer(), nullable=False),
        sa.Column("share_code", sa.String(12), nullable=True),
        sa.Column("in_bank", sa.Boolean(), nullable=False),
        sa.Column("created_at", TIME, nullable=False),
        sa.Column("saved_at", TIME, nullable=False),
        sa.ForeignKeyConstraint(
            ["author_id"], ["account.id"], name=op.f("fk_authored_exercise_author_id_account"), ondelete="SET NULL"
        ),
        sa.UniqueConstraint("module", "slug", name=op.f("uq_authored_exercise_module_slug")),
        sa.UniqueConstraint("share_code", name=op.f("uq_authored_exercise_share_code")),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_authored_exercise")),
    )
    op.create_index(op.f("ix_authored_exercise_author_id"), "authored_exercise", ["author_id"])
    op.create_table(
        "exercise_version",
        sa.Column("exercise_id", sa.Uuid(), nullable=False),
        sa.Column("number", sa.Integer(), nullable=False),
        sa.Column("version", sa.String(64), nullable=False),
        sa.Column("content", sa.JSON(), nullable=False),
        sa.Column("fingerprints", sa.JSON(), nullable=False),
        sa.Column("published_at", TIME, nullable=False),
        sa.ForeignKeyConstraint(
            ["exercise_id"],
            ["authored_exercise.id"],
            name=op.f("fk_exercise_version_exercise_id_authored_exercise"),
            ondelete="CASCADE",
        ),
        sa.PrimaryKeyConstraint("exercise_id", "number", name=op.f("pk_exercise_version")),
    )


def downgrade() -> None:
    op.drop_table("exercise_version")
    op.drop_table("authored_exercise")
