"""Deleted assignments stay for a while, so that a deletion can be undone"""

import sqlalchemy as sa
from alembic import op

revision = "0030"
down_revision = "0029"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.add_column("assignment", sa.Column("removed_at", sa.DateTime(timezone=True), nullable=True))


def downgrade() -> None:
    op.execute("DELETE FROM assignment WHERE removed_at IS NOT NULL")
    op.drop_column("assignment", "removed_at")
