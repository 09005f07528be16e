"""Students who hand in an assignment together"""

import sqlalchemy as sa
from alembic import op

revision = "0043"
down_revision = "0042"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.add_column("assignment", sa.Column("team_size", sa.Integer(), nullable=False, server_default="1"))
    op.add_column("assignment", sa.Column("teams_by_students", sa.Boolean(), nullable=False, server_default=sa.false()))
    op.create_table(
        "team_member",
        sa.Column("id", sa.Uuid(), nullable=False),
        sa.Column("assignment_id", sa.Uuid(), nullable=False),
        sa.Column("team_id", sa.Uuid(), nullable=False),
        sa.Column("account_id", sa.Uuid(), nullable=False),
        sa.Column("since", sa.DateTime(timezone=True), nullable=False),
        sa.Column("until", sa.DateTime(timezone=True), nullable=True),
        sa.ForeignKeyConstraint(
            ["account_id"], ["account.id"], name=op.f("fk_team_member_account_id_account"), ondelete="CASCADE"
        ),
        sa.ForeignKeyConstraint(
            ["assignment_id"],
            ["assignment.id"],
            name=op.f("fk_team_member_assignment_id_assignment"),
            ondelete="CASCADE",
        ),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_team_member")),
    )
    op.create_index(op.f("ix_team_member_account_id"), "team_member", ["account_id"])
    op.create_index(op.f("ix_team_member_assignment_id"), "team_member", ["assignment_id"])
    current = sa.text("until IS NULL")
    op.create_index(
        "uq_team_member_current",
        "team_member",
        ["assignment_id", "account_id"],
        unique=True,
        sqlite_where=current,
        postgresql_where=current,
    )
    op.create_table(
        "team_proposal",
        sa.Column("assignment_id", sa.Uuid(), nullable=False),
        sa.Column("account_id", sa.Uuid(), nullable=False),
        sa.Column("partner_id", sa.Uuid(), nullable=False),
        sa.Column("proposed_at", sa.DateTime(timezone=True), nullable=False),
        sa.ForeignKeyConstraint(
            ["account_id"], ["account.id"], name=op.f("fk_team_proposal_account_id_account"), ondelete="CASCADE"
        ),
        sa.ForeignKeyConstraint(
            ["assignment_id"],
            ["assignment.id"],
            name=op.f("fk_team_proposal_assignment_id_assignment"),
            ondelete="CASCADE",
        ),
        sa.ForeignKeyConstraint(
            ["partner_id"], ["account.id"], name=op.f("fk_team_proposal_partner_id_account"), ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("assignment_id", "account_id", "partner_id", name=op.f("pk_team_proposal")),
    )
    op.create_index(op.f("ix_team_proposal_account_id"), "team_proposal", ["account_id"])
    op.create_index(op.f("ix_team_proposal_partner_id"), "team_proposal", ["partner_id"])


def downgrade() -> None:
    op.drop_table("team_proposal")
    op.drop_table("team_member")
    op.drop_column("assignment", "teams_by_students")
    op.drop_column("assignment", "team_size")
