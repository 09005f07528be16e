"""Each grading names the version of Balise that made it"""

import sqlalchemy as sa
from alembic import op

revision = "0031"
down_revision = "0030"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.add_column("grading", sa.Column("balise_version", sa.String(32), nullable=True))


def downgrade() -> None:
    op.drop_column("grading", "balise_version")
