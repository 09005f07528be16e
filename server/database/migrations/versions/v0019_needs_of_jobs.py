"""What a job needs of its worker, and since when it waits for one that has it"""

import sqlalchemy as sa
from alembic import op

revision = "0019"
down_revision = "0018"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.add_column("job", sa.Column("needs", sa.String(length=300), nullable=True))
    op.add_column("job", sa.Column("refused_at", sa.DateTime(timezone=True), nullable=True))


def downgrade() -> None:
    for column in ("refused_at", "needs"):
        op.drop_column("job", column)
