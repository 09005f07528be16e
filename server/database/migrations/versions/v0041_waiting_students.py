"""Students of a school's class that no class is tied to yet"""

import sqlalchemy as sa
from alembic import op

revision = "0041"
down_revision = "0040"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "waiting_student",
        sa.Column("context_id", sa.Uuid(), nullable=False),
        sa.Column("account_id", sa.Uuid(), nullable=False),
        sa.Column("given_name", sa.String(100), nullable=False),
        sa.Column("family_name", sa.String(100), nullable=False),
        sa.Column("seen_at", sa.DateTime(timezone=True), nullable=False),
        sa.ForeignKeyConstraint(
            ["account_id"], ["account.id"], name=op.f("fk_waiting_student_account_id_account"), ondelete="CASCADE"
        ),
        sa.ForeignKeyConstraint(
            ["context_id"],
            ["provider_context.id"],
            name=op.f("fk_waiting_student_context_id_provider_context"),
            ondelete="CASCADE",
        ),
        sa.PrimaryKeyConstraint("context_id", "account_id", name=op.f("pk_waiting_student")),
    )
    op.create_index(op.f("ix_waiting_student_account_id"), "waiting_student", ["account_id"])


def downgrade() -> None:
    op.drop_table("waiting_student")
