"""Films: what a student's program did in a check is kept with its grading"""

import sqlalchemy as sa
from alembic import op

revision = "0016"
down_revision = "0014"
branch_labels = None
depends_on = None

COLUMNS = ("filmed", "films")


def upgrade() -> None:
    for column in COLUMNS:
        op.add_column("grading", sa.Column(column, sa.JSON(), nullable=True))


def downgrade() -> None:
    for column in COLUMNS:
        op.drop_column("grading", column)
