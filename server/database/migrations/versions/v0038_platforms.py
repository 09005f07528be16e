"""Platforms of schools: providers of identities, their courses, and marks to send; audit events of the server"""

import sqlalchemy as sa
from alembic import op

revision = "0038"
down_revision = "0037"
branch_labels = None
depends_on = None

TIME = sa.DateTime(timezone=True)
TABLES = (
    "identity_provider", "provider_activity", "registration_link", "pending_sign_in", "provider_context",
    "context_teacher", "line_item", "mark_delivery", "signing_key",
)  # fmt: skip


def upgrade() -> None:
    op.create_table(
        "identity_provider",
        sa.Column("id", sa.Uuid(), nullable=False),
        sa.Column("protocol", sa.String(8), nullable=False),
        sa.Column("name", sa.String(100), nullable=False),
        sa.Column("issuer", sa.String(500), nullable=False),
        sa.Column("client_id", sa.String(255), nullable=False),
        sa.Column("settings", sa.JSON(), nullable=False),
        sa.Column("trusts_teachers", sa.Boolean(), nullable=False),
        sa.Column("created_at", TIME, nullable=False),
        sa.Column("created_by", sa.Uuid(), nullable=True),
        sa.Column("paused_at", TIME, nullable=True),
        sa.ForeignKeyConstraint(
            ["created_by"], ["account.id"], name=op.f("fk_identity_provider_created_by_account"), ondelete="SET NULL"
        ),
        sa.UniqueConstraint("issuer", "client_id", name=op.f("uq_identity_provider_issuer_client_id")),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_identity_provider")),
    )
    op.create_index(op.f("ix_identity_provider_created_by"), "identity_provider", ["created_by"])
    op.create_table(
        "provider_activity",
        sa.Column("provider_id", sa.Uuid(), nullable=False),
        sa.Column("kind", sa.String(16), nullable=False),
        sa.Column("succeeded", sa.Boolean(), nullable=False),
        sa.Column("at", TIME, nullable=False),
        sa.Column("detail", sa.String(300), nullable=False),
        sa.ForeignKeyConstraint(
            ["provider_id"],
            ["identity_provider.id"],
            name=op.f("fk_provider_activity_provider_id_identity_provider"),
            ondelete="CASCADE",
        ),
        sa.PrimaryKeyConstraint("provider_id", "kind", "succeeded", name=op.f("pk_provider_activity")),
    )
    op.create_table(
        "registration_link",
        sa.Column("token_digest", sa.String(64), nullable=False),
        sa.Column("created_by", sa.Uuid(), nullable=True),
        sa.Column("created_at", TIME, nullable=False),
        sa.Column("expires_at", TIME, nullable=False),
        sa.ForeignKeyConstraint(
            ["created_by"], ["account.id"], name=op.f("fk_registration_link_created_by_account"), ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("token_digest", name=op.f("pk_registration_link")),
    )
    op.create_index(op.f("ix_registration_link_created_by"), "registration_link", ["created_by"])
    op.create_table(
        "pending_sign_in",
        sa.Column("state_digest", sa.String(64), nullable=False),
        sa.Column("provider_id", sa.Uuid(), nullable=False),
        sa.Column("nonce_digest", sa.String(64), nullable=False),
        sa.Column("browser_digest", sa.String(64), nullable=False),
        sa.Column("target", sa.String(2000), nullable=False),
        sa.Column("details", sa.JSON(), nullable=False),
        sa.Column("expires_at", TIME, nullable=False),
        sa.ForeignKeyConstraint(
            ["provider_id"],
            ["identity_provider.id"],
            name=op.f("fk_pending_sign_in_provider_id_identity_provider"),
            ondelete="CASCADE",
        ),
        sa.PrimaryKeyConstraint("state_digest", name=op.f("pk_pending_sign_in")),
    )
    op.create_index(op.f("ix_pending_sign_in_expires_at"), "pending_sign_in", ["expires_at"])
    op.create_index(op.f("ix_pending_sign_in_provider_id"), "pending_sign_in", ["provider_id"])
    op.create_table(
        "provider_context",
        sa.Column("id", sa.Uuid(), nullable=False),
        sa.Column("provider_id", sa.Uuid(), nullable=False),
        sa.Column("deployment", sa.String(255), nullable=False),
        sa.Column("context", sa.String(255), nullable=False),
        sa.Column("title", sa.String(100), nullable=False),
        sa.Column("class_id", sa.Uuid(), nullable=True),
        sa.Column("linked_by", sa.Uuid(), nullable=True),
        sa.Column("roster_url", sa.String(2000), nullable=False),
        sa.Column("line_items_url", sa.String(2000), nullable=False),
        sa.Column("scopes", sa.JSON(), nullable=False),
        sa.Column("seen_at", TIME, nullable=False),
        sa.ForeignKeyConstraint(
            ["provider_id"],
            ["identity_provider.id"],
            name=op.f("fk_provider_context_provider_id_identity_provider"),
            ondelete="CASCADE",
        ),
        sa.ForeignKeyConstraint(
            ["class_id"],
            ["school_class.id"],
            name=op.f("fk_provider_context_class_id_school_class"),
            ondelete="SET NULL",
        ),
        sa.ForeignKeyConstraint(
            ["linked_by"], ["account.id"], name=op.f("fk_provider_context_linked_by_account"), ondelete="SET NULL"
        ),
        sa.UniqueConstraint(
            "provider_id", "deployment", "context", name=op.f("uq_provider_context_provider_id_deployment_context")
        ),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_provider_context")),
    )
    op.create_index(op.f("ix_provider_context_class_id"), "provider_context", ["class_id"])
    op.create_index(op.f("ix_provider_context_linked_by"), "provider_context", ["linked_by"])
    op.create_table(
        "context_teacher",
        sa.Column("context_id", sa.Uuid(), nullable=False),
        sa.Column("account_id", sa.Uuid(), nullable=False),
        sa.Column("seen_at", TIME, nullable=False),
        sa.ForeignKeyConstraint(
            ["account_id"], ["account.id"], name=op.f("fk_context_teacher_account_id_account"), ondelete="CASCADE"
        ),
        sa.ForeignKeyConstraint(
            ["context_id"],
            ["provider_context.id"],
            name=op.f("fk_context_teacher_context_id_provider_context"),
            ondelete="CASCADE",
        ),
        sa.PrimaryKeyConstraint("context_id", "account_id", name=op.f("pk_context_teacher")),
    )
    op.create_index(op.f("ix_context_teacher_account_id"), "context_teacher", ["account_id"])
    op.create_table(
        "line_item",
        sa.Column("id", sa.Uuid(), nullable=False),
        sa.Column("context_id", sa.Uuid(), nullable=False),
        sa.Column("assignment_id", sa.Uuid(), nullable=False),
        sa.Column("url", sa.String(2000), nullable=True),
        sa.Column("problem", sa.String(300), nullable=False),
        sa.Column("check_at", TIME, nullable=False),
        sa.Column("created_at", TIME, nullable=False),
        sa.ForeignKeyConstraint(
            ["assignment_id"], ["assignment.id"], name=op.f("fk_line_item_assignment_id_assignment"), ondelete="CASCADE"
        ),
        sa.ForeignKeyConstraint(
            ["context_id"],
            ["provider_context.id"],
            name=op.f("fk_line_item_context_id_provider_context"),
            ondelete="CASCADE",
        ),
        sa.UniqueConstraint("context_id", "assignment_id", name=op.f("uq_line_item_context_id_assignment_id")),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_line_item")),
    )
    op.create_index(op.f("ix_line_item_assignment_id"), "line_item", ["assignment_id"])
    op.create_table(
        "mark_delivery",
        sa.Column("line_item_id", sa.Uuid(), nullable=False),
        sa.Column("account_id", sa.Uuid(), nullable=False),
        sa.Column("points", sa.Double(), nullable=False),
        sa.Column("sent_points", sa.Double(), nullable=True),
        sa.Column("state", sa.String(8), nullable=False),
        sa.Column("reason", sa.String(300), nullable=False),
        sa.Column("tries", sa.Integer(), nullable=False),
        sa.Column("told_at", TIME, nullable=True),
        sa.Column("sent_at", TIME, nullable=True),
        sa.Column("next_try_at", TIME, nullable=False),
        sa.ForeignKeyConstraint(
            ["account_id"], ["account.id"], name=op.f("fk_mark_delivery_account_id_account"), ondelete="CASCADE"
        ),
        sa.ForeignKeyConstraint(
            ["line_item_id"], ["line_item.id"], name=op.f("fk_mark_delivery_line_item_id_line_item"), ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("line_item_id", "account_id", name=op.f("pk_mark_delivery")),
    )
    op.create_index(op.f("ix_mark_delivery_account_id"), "mark_delivery", ["account_id"])
    op.create_table(
        "signing_key",
        sa.Column("id", sa.Uuid(), nullable=False),
        sa.Column("private_pem", sa.Text(), nullable=False),
        sa.Column("created_at", TIME, nullable=False),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_signing_key")),
    )
    with op.batch_alter_table("audit_event") as events:
        events.alter_column("class_id", existing_type=sa.Uuid(), nullable=True)


def downgrade() -> None:
    op.execute("DELETE FROM audit_event WHERE class_id IS NULL")
    with op.batch_alter_table("audit_event") as events:
        events.alter_column("class_id", existing_type=sa.Uuid(), nullable=False)
    for table in reversed(TABLES):
        op.drop_table(table)
