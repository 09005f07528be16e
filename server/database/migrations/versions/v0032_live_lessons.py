"""Lessons of classes, and the students seen in them"""

import sqlalchemy as sa
from alembic import op

revision = "0032"
down_revision = "0031"
branch_labels = None
depends_on = None

TIME = sa.DateTime(timezone=True)


def upgrade() -> None:
    op.create_table(
        "live_lesson",
        sa.Column("id", sa.Uuid(), primary_key=True),
        sa.Column("class_id", sa.Uuid(), sa.ForeignKey("school_class.id", ondelete="CASCADE"), nullable=False),
        sa.Column("exercises", sa.JSON(), nullable=False),
        sa.Column("next_step", sa.String(16), nullable=False),
        sa.Column("challenge", sa.String(200), nullable=True),
        sa.Column("started_at", TIME, nullable=False),
        sa.Column("ended_at", TIME, nullable=True),
        sa.Column("started_by", sa.Uuid(), sa.ForeignKey("account.id", ondelete="SET NULL"), nullable=True),
    )
    op.create_index("ix_live_lesson_class_id_started_at", "live_lesson", ["class_id", "started_at"])
    op.create_index("ix_live_lesson_started_by", "live_lesson", ["started_by"])
    op.create_table(
        "lesson_visit",
        sa.Column("lesson_id", sa.Uuid(), sa.ForeignKey("live_lesson.id", ondelete="CASCADE"), primary_key=True),
        sa.Column("account_id", sa.Uuid(), sa.ForeignKey("account.id", ondelete="CASCADE"), primary_key=True),
        sa.Column("exercise", sa.String(200), nullable=False),
        sa.Column("visited_at", TIME, nullable=False),
    )
    op.create_index("ix_lesson_visit_account_id", "lesson_visit", ["account_id"])


def downgrade() -> None:
    op.drop_table("lesson_visit")
    op.drop_table("live_lesson")
