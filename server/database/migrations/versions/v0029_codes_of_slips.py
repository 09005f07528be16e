"""Slips have a short code, kept until it is used

Links of slips that are out already stay good, and are replaced when their slips are made again.
"""

import sqlalchemy as sa
from alembic import op

revision = "0029"
down_revision = "0028"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.add_column("password_link", sa.Column("code", sa.String(8), nullable=True))


def downgrade() -> None:
    op.drop_column("password_link", "code")
