"""Classes and their members, solutions opened to a class; the first teacher becomes the administrator

What was open to everyone stays so. A teacher sees their own classes only from now on: who was alone to see everything
goes on doing so, as administrator.
"""

import sqlalchemy as sa
from alembic import op

revision = "0006"
down_revision = "0005"
branch_labels = None
depends_on = None

TIME = sa.DateTime(timezone=True)


def upgrade() -> None:
    op.create_table(
        "school_class",
        sa.Column("id", sa.Uuid(), nullable=False),
        sa.Column("name", sa.String(length=100), nullable=False),
        sa.Column("module", sa.String(length=100), nullable=False),
        sa.Column("created_by", sa.Uuid(), nullable=True),
        sa.Column("created_at", TIME, nullable=False),
        sa.Column("archived_at", TIME, nullable=True),
        sa.Column("join_code", sa.String(length=8), nullable=True),
        sa.Column("join_code_until", TIME, nullable=True),
        sa.Column("approval", sa.Boolean(), nullable=False),
        sa.ForeignKeyConstraint(
            ["created_by"], ["account.id"], name=op.f("fk_school_class_created_by_account"), ondelete="SET NULL"
        ),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_school_class")),
        sa.UniqueConstraint("join_code", name=op.f("uq_school_class_join_code")),
    )
    op.create_table(
        "membership",
        sa.Column("class_id", sa.Uuid(), nullable=False),
        sa.Column("account_id", sa.Uuid(), nullable=False),
        sa.Column("role", sa.String(length=16), nullable=False),
        sa.Column("status", sa.String(length=16), nullable=False),
        sa.Column("family_name", sa.String(length=100), nullable=False),
        sa.Column("given_name", sa.String(length=100), nullable=False),
        sa.Column("email", sa.String(length=254), nullable=False),
        sa.Column("groups", sa.JSON(), nullable=False),
        sa.Column("made_here", sa.Boolean(), nullable=False),
        sa.Column("went", sa.Boolean(), nullable=False),
        sa.Column("joined_at", TIME, nullable=False),
        sa.Column("left_at", TIME, nullable=True),
        sa.Column("last_seen_at", TIME, nullable=True),
        sa.ForeignKeyConstraint(
            ["class_id"],
            ["school_class.id"],
            name=op.f("fk_membership_class_id_school_class"),
            ondelete="CASCADE",
        ),
        sa.ForeignKeyConstraint(
            ["account_id"], ["account.id"], name=op.f("fk_membership_account_id_account"), ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("class_id", "account_id", name=op.f("pk_membership")),
    )
    op.create_index(op.f("ix_membership_account_id"), "membership", ["account_id"])
    op.create_table(
        "class_opening",
        sa.Column("class_id", sa.Uuid(), nullable=False),
        sa.Column("exercise", sa.String(length=200), nullable=False),
        sa.Column("opened_by", sa.Uuid(), nullable=True),
        sa.Column("opened_at", TIME, nullable=False),
        sa.ForeignKeyConstraint(
            ["class_id"],
            ["school_class.id"],
            name=op.f("fk_class_opening_class_id_school_class"),
            ondelete="CASCADE",
        ),
        sa.ForeignKeyConstraint(
            ["opened_by"], ["account.id"], name=op.f("fk_class_opening_opened_by_account"), ondelete="SET NULL"
        ),
        sa.PrimaryKeyConstraint("class_id", "exercise", name=op.f("pk_class_opening")),
    )
    account = sa.table("account", sa.column("id", sa.Uuid()), sa.column("role"), sa.column("created_at", TIME))
    first = sa.select(account.c.id).where(account.c.role == "teacher").order_by(account.c.created_at, account.c.id)
    op.execute(sa.update(account).where(account.c.id == first.limit(1).scalar_subquery()).values(role="administrator"))
    op.execute(sa.text("UPDATE invitation SET role = 'administrator' WHERE role = 'teacher' AND used_at IS NULL"))


def downgrade() -> None:
    op.execute(sa.text("UPDATE invitation SET role = 'teacher' WHERE role = 'administrator'"))
    op.execute(sa.text("UPDATE account SET role = 'teacher' WHERE role = 'administrator'"))
    op.drop_table("class_opening")
    op.drop_table("membership")
    op.drop_table("school_class")
