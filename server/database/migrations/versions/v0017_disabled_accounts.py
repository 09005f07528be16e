"""Accounts that are disabled, and invitations that end"""

import sqlalchemy as sa
from alembic import op

revision = "0017"
down_revision = "0016"
branch_labels = None
depends_on = None

TIME = sa.DateTime(timezone=True)


def upgrade() -> None:
    op.add_column("account", sa.Column("disabled_at", TIME, nullable=True))
    op.add_column("invitation", sa.Column("expires_at", TIME, nullable=True))


def downgrade() -> None:
    op.drop_column("invitation", "expires_at")
    op.drop_column("account", "disabled_at")
