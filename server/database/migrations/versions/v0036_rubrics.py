"""Rubrics, and the copies that are marked by them"""

import sqlalchemy as sa
from alembic import op

revision = "0036"
down_revision = "0035"
branch_labels = None
depends_on = None

TIME = sa.DateTime(timezone=True)


def upgrade() -> None:
    op.create_table(
        "rubric",
        sa.Column("column_id", sa.Uuid(), sa.ForeignKey("manual_column.id", ondelete="CASCADE"), primary_key=True),
        sa.Column("assignment_id", sa.Uuid(), sa.ForeignKey("assignment.id", ondelete="CASCADE"), nullable=False),
        sa.Column("items", sa.JSON(), nullable=False),
        sa.Column("anonymous", sa.Boolean(), nullable=False),
        sa.Column("version", sa.Integer(), nullable=False),
    )
    op.create_index("ix_rubric_assignment_id", "rubric", ["assignment_id"])
    op.create_table(
        "rubric_marking",
        sa.Column("column_id", sa.Uuid(), sa.ForeignKey("rubric.column_id", ondelete="CASCADE"), primary_key=True),
        sa.Column("account_id", sa.Uuid(), sa.ForeignKey("account.id", ondelete="CASCADE"), primary_key=True),
        sa.Column("points", sa.JSON(), nullable=False),
        sa.Column("remarks", sa.JSON(), nullable=False),
        sa.Column("finished_at", TIME, nullable=True),
        sa.Column("by", sa.Uuid(), sa.ForeignKey("account.id", ondelete="SET NULL"), nullable=True),
        sa.Column("at", TIME, nullable=False),
        sa.Column("version", sa.Integer(), nullable=False),
    )
    op.create_index("ix_rubric_marking_account_id", "rubric_marking", ["account_id"])
    op.create_index("ix_rubric_marking_by", "rubric_marking", ["by"])


def downgrade() -> None:
    op.drop_table("rubric_marking")
    op.drop_table("rubric")
