"""Identities of accounts in other systems, beside the password"""

import sqlalchemy as sa
from alembic import op

revision = "0037"
down_revision = "0036"
branch_labels = None
depends_on = None

TIME = sa.DateTime(timezone=True)
OWNER = "fk_federated_identity_account_id_account"
OPENER = "fk_browser_session_identity_id_federated_identity"


def upgrade() -> None:
    op.create_table(
        "federated_identity",
        sa.Column("id", sa.Uuid(), nullable=False),
        sa.Column("account_id", sa.Uuid(), nullable=False),
        sa.Column("issuer", sa.String(500), nullable=False),
        sa.Column("subject", sa.String(255), nullable=False),
        sa.Column("created_at", TIME, nullable=False),
        sa.Column("seen_at", TIME, nullable=True),
        sa.ForeignKeyConstraint(["account_id"], ["account.id"], name=op.f(OWNER), ondelete="CASCADE"),
        sa.UniqueConstraint("issuer", "subject", name=op.f("uq_federated_identity_issuer_subject")),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_federated_identity")),
    )
    op.create_index(op.f("ix_federated_identity_account_id"), "federated_identity", ["account_id"])
    with op.batch_alter_table("browser_session") as sessions:
        sessions.add_column(sa.Column("identity_id", sa.Uuid(), nullable=True))
        sessions.add_column(sa.Column("external_digest", sa.String(64), nullable=True))
        sessions.add_column(sa.Column("frames", sa.String(1000), nullable=True))
        sessions.create_foreign_key(OPENER, "federated_identity", ["identity_id"], ["id"], ondelete="CASCADE")
        sessions.create_index("ix_browser_session_identity_id", ["identity_id"])
        sessions.create_index("ix_browser_session_external_digest", ["external_digest"])
    op.execute("UPDATE browser_session SET frames = ''")
    with op.batch_alter_table("browser_session") as sessions:
        sessions.alter_column("frames", existing_type=sa.String(1000), nullable=False)
    # Not in a batch: SQLite would copy the table, and drop the first one with all that hangs on it.
    op.add_column("account", sa.Column("has_pseudonym", sa.Boolean(), nullable=False, server_default=sa.false()))


def downgrade() -> None:
    op.drop_column("account", "has_pseudonym")
    with op.batch_alter_table("browser_session") as sessions:
        sessions.drop_index("ix_browser_session_external_digest")
        sessions.drop_index("ix_browser_session_identity_id")
        sessions.drop_constraint(OPENER, type_="foreignkey")
        for column in ("frames", "external_digest", "identity_id"):
            sessions.drop_column(column)
    op.drop_table("federated_identity")
