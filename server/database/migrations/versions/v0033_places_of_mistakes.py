"""The places of a program's mistakes, found after its verdict"""

import sqlalchemy as sa
from alembic import op

revision = "0033"
down_revision = "0032"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.add_column("fingerprint", sa.Column("place", sa.JSON(), nullable=True))
    op.add_column("fingerprint", sa.Column("changes", sa.String(200), nullable=True))


def downgrade() -> None:
    op.drop_column("fingerprint", "changes")
    op.drop_column("fingerprint", "place")
