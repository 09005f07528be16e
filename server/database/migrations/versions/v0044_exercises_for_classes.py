"""Exercises that a teacher proposes to her classes, and tries as a student"""

import sqlalchemy as sa
from alembic import op

revision = "0044"
down_revision = "0043"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.add_column("authored_exercise", sa.Column("for_classes", sa.Boolean(), nullable=True))
    op.add_column("authored_exercise", sa.Column("tryout", sa.JSON(), nullable=True))
    op.execute("UPDATE authored_exercise SET for_classes = false")
    with op.batch_alter_table("authored_exercise") as batch:
        batch.alter_column("for_classes", existing_type=sa.Boolean(), nullable=False)


def downgrade() -> None:
    op.drop_column("authored_exercise", "tryout")
    op.drop_column("authored_exercise", "for_classes")
