"""Threads of messages on what students send, phrases that teachers keep, words to several students"""

import sqlalchemy as sa
from alembic import op

revision = "0009"
down_revision = "0008"
branch_labels = None
depends_on = None

TIME = sa.DateTime(timezone=True)


def _to(table: str, column: str, other: str, gone: str) -> sa.ForeignKeyConstraint:
    return sa.ForeignKeyConstraint([column], [f"{other}.id"], name=op.f(f"fk_{table}_{column}_{other}"), ondelete=gone)


def upgrade() -> None:
    op.create_table(
        "thread",
        sa.Column("id", sa.Uuid(), nullable=False),
        sa.Column("account_id", sa.Uuid(), nullable=False),
        sa.Column("exercise", sa.String(length=200), nullable=False),
        sa.Column("submission_id", sa.Uuid(), nullable=True),
        sa.Column("work_at", TIME, nullable=False),
        sa.Column("first_line", sa.Integer(), nullable=True),
        sa.Column("last_line", sa.Integer(), nullable=True),
        sa.Column("check_id", sa.String(length=200), nullable=True),
        sa.Column("check_title", sa.String(length=300), nullable=False),
        sa.Column("by_staff", sa.Boolean(), nullable=False),
        sa.Column("state", sa.String(length=16), nullable=False),
        sa.Column("created_at", TIME, nullable=False),
        sa.Column("changed_at", TIME, nullable=False),
        sa.Column("staff_at", TIME, nullable=True),
        sa.Column("seen_at", TIME, nullable=True),
        _to("thread", "account_id", "account", "CASCADE"),
        _to("thread", "submission_id", "submission", "CASCADE"),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_thread")),
    )
    op.create_index("ix_thread_account_id_exercise", "thread", ["account_id", "exercise"])
    op.create_index(op.f("ix_thread_submission_id"), "thread", ["submission_id"])
    op.create_table(
        "message",
        sa.Column("id", sa.Uuid(), nullable=False),
        sa.Column("thread_id", sa.Uuid(), nullable=False),
        sa.Column("author_id", sa.Uuid(), nullable=True),
        sa.Column("as_staff", sa.Boolean(), nullable=False),
        sa.Column("text", sa.Text(), nullable=False),
        sa.Column("created_at", TIME, nullable=False),
        _to("message", "thread_id", "thread", "CASCADE"),
        _to("message", "author_id", "account", "SET NULL"),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_message")),
    )
    op.create_index(op.f("ix_message_thread_id"), "message", ["thread_id"])
    op.create_index(op.f("ix_message_author_id"), "message", ["author_id"])
    op.create_table(
        "phrase",
        sa.Column("id", sa.Uuid(), nullable=False),
        sa.Column("account_id", sa.Uuid(), nullable=False),
        sa.Column("exercise", sa.String(length=200), nullable=True),
        sa.Column("misconception", sa.String(length=200), nullable=True),
        sa.Column("text", sa.Text(), nullable=False),
        sa.Column("uses", sa.Integer(), nullable=False),
        sa.Column("created_at", TIME, nullable=False),
        _to("phrase", "account_id", "account", "CASCADE"),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_phrase")),
    )
    op.create_index(op.f("ix_phrase_account_id"), "phrase", ["account_id"])
    op.create_table(
        "note",
        sa.Column("id", sa.Uuid(), nullable=False),
        sa.Column("class_id", sa.Uuid(), nullable=False),
        sa.Column("exercise", sa.String(length=200), nullable=False),
        sa.Column("misconception", sa.String(length=200), nullable=True),
        sa.Column("text", sa.Text(), nullable=False),
        sa.Column("link", sa.String(length=300), nullable=False),
        sa.Column("account_id", sa.Uuid(), nullable=True),
        sa.Column("created_at", TIME, nullable=False),
        _to("note", "class_id", "school_class", "CASCADE"),
        _to("note", "account_id", "account", "SET NULL"),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_note")),
    )
    op.create_index(op.f("ix_note_class_id"), "note", ["class_id"])
    op.create_index(op.f("ix_note_account_id"), "note", ["account_id"])
    op.create_table(
        "note_reader",
        sa.Column("note_id", sa.Uuid(), nullable=False),
        sa.Column("account_id", sa.Uuid(), nullable=False),
        sa.Column("seen_at", TIME, nullable=True),
        _to("note_reader", "note_id", "note", "CASCADE"),
        _to("note_reader", "account_id", "account", "CASCADE"),
        sa.PrimaryKeyConstraint("note_id", "account_id", name=op.f("pk_note_reader")),
    )
    op.create_index(op.f("ix_note_reader_account_id"), "note_reader", ["account_id"])


def downgrade() -> None:
    for table in ("note_reader", "note", "phrase", "message", "thread"):
        op.drop_table(table)
