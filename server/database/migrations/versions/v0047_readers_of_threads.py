"""Who has read a thread: each of those who hand in together, instead of the author alone"""

import sqlalchemy as sa
from alembic import op

revision = "0047"
down_revision = "0046"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "thread_reader",
        sa.Column("thread_id", sa.Uuid(), nullable=False),
        sa.Column("account_id", sa.Uuid(), nullable=False),
        sa.Column("seen_at", sa.DateTime(timezone=True), nullable=False),
        sa.ForeignKeyConstraint(
            ["account_id"], ["account.id"], name=op.f("fk_thread_reader_account_id_account"), ondelete="CASCADE"
        ),
        sa.ForeignKeyConstraint(
            ["thread_id"], ["thread.id"], name=op.f("fk_thread_reader_thread_id_thread"), ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("thread_id", "account_id", name=op.f("pk_thread_reader")),
    )
    op.create_index(op.f("ix_thread_reader_account_id"), "thread_reader", ["account_id"])
    op.execute(
        "INSERT INTO thread_reader (thread_id, account_id, seen_at)"
        " SELECT id, account_id, seen_at FROM thread WHERE seen_at IS NOT NULL"
    )
    op.drop_column("thread", "seen_at")


def downgrade() -> None:
    op.add_column("thread", sa.Column("seen_at", sa.DateTime(timezone=True), nullable=True))
    op.execute(
        "UPDATE thread SET seen_at = (SELECT seen_at FROM thread_reader"
        " WHERE thread_reader.thread_id = thread.id AND thread_reader.account_id = thread.account_id)"
    )
    op.drop_table("thread_reader")
