"""Time: the rules that an assignment had before, and exemptions that never leave less than the others have"""

import sqlalchemy as sa
from alembic import op

revision = "0026"
down_revision = "0025"
branch_labels = None
depends_on = None

#: A date that is earlier than the others' today was either chosen so, or left behind: it holds as before, and its
#: teacher is told.
NOT_EARLIER = """
UPDATE exemption SET extends = true WHERE NOT EXISTS (
    SELECT 1 FROM assignment WHERE assignment.id = exemption.assignment_id AND (
        (exemption.due_at IS NOT NULL AND (assignment.due_at IS NULL OR exemption.due_at < assignment.due_at))
        OR (
            exemption.closes_at IS NOT NULL
            AND (assignment.closes_at IS NULL OR exemption.closes_at < assignment.closes_at)
        )
    )
)
"""


def upgrade() -> None:
    op.add_column("assignment", sa.Column("past_rules", sa.Text(), nullable=False, server_default="[]"))
    op.add_column("exemption", sa.Column("extends", sa.Boolean(), nullable=False, server_default=sa.false()))
    op.execute(NOT_EARLIER)


def downgrade() -> None:
    op.drop_column("exemption", "extends")
    op.drop_column("assignment", "past_rules")
