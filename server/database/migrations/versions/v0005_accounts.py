"""API tokens that end and say when they last served, links to a new password, erasure without reading every row"""

from datetime import UTC, datetime, timedelta

import sqlalchemy as sa
from alembic import op

revision = "0005"
down_revision = "0004"
branch_labels = None
depends_on = None

TIME = sa.DateTime(timezone=True)
LEFT = timedelta(days=365)  # to the tokens that had no end


def upgrade() -> None:
    op.add_column("api_token", sa.Column("last_used_at", TIME, nullable=True))
    op.add_column("api_token", sa.Column("expires_at", TIME, nullable=True))
    ends = sa.table("api_token", sa.column("expires_at", TIME))
    op.execute(sa.update(ends).values(expires_at=datetime.now(UTC) + LEFT))
    with op.batch_alter_table("api_token") as table:  # nothing refers to it
        table.alter_column("expires_at", existing_type=TIME, nullable=False)
    op.create_table(
        "password_link",
        sa.Column("account_id", sa.Uuid(), nullable=False),
        sa.Column("token_digest", sa.String(length=64), nullable=False),
        sa.Column("created_at", TIME, nullable=False),
        sa.Column("expires_at", TIME, nullable=False),
        sa.ForeignKeyConstraint(
            ["account_id"], ["account.id"], name=op.f("fk_password_link_account_id_account"), ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("account_id", name=op.f("pk_password_link")),
        sa.UniqueConstraint("token_digest", name=op.f("uq_password_link_token_digest")),
    )
    op.create_index("ix_submission_grading_id", "submission", ["grading_id"])


def downgrade() -> None:
    op.drop_index("ix_submission_grading_id", "submission")
    op.drop_table("password_link")
    with op.batch_alter_table("api_token") as table:
        table.drop_column("expires_at")
        table.drop_column("last_used_at")
