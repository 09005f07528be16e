"""Verdicts that are shown while the name of a mistake is sought"""

import sqlalchemy as sa
from alembic import op

revision = "0034"
down_revision = "0033"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "early_verdict",
        sa.Column("submission_id", sa.Uuid(), sa.ForeignKey("submission.id", ondelete="CASCADE"), primary_key=True),
        sa.Column("verdict", sa.JSON(), nullable=False),
    )


def downgrade() -> None:
    op.drop_table("early_verdict")
