"""Counts: what the workers of other machines count of themselves"""

import sqlalchemy as sa
from alembic import op

revision = "0020"
down_revision = "0019"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "count",
        sa.Column("name", sa.String(length=64), nullable=False),
        sa.Column("why", sa.String(length=64), nullable=False),
        sa.Column("times", sa.BigInteger(), nullable=False),
        sa.PrimaryKeyConstraint("name", "why", name=op.f("pk_count")),
    )


def downgrade() -> None:
    op.drop_table("count")
