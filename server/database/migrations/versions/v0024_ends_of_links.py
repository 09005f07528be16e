"""Links to a password have the reasons for which they were made, and members are known by the list or not"""

import sqlalchemy as sa
from alembic import op

revision = "0024"
down_revision = "0023"
branch_labels = None
depends_on = None

MAKER = "fk_password_link_made_by_account"


def upgrade() -> None:
    with op.batch_alter_table("password_link") as batch:
        batch.add_column(sa.Column("role", sa.String(16), nullable=True))
        batch.add_column(sa.Column("class_id", sa.Uuid(), nullable=True))
        batch.add_column(sa.Column("made_by", sa.Uuid(), nullable=True))
        batch.create_foreign_key(MAKER, "account", ["made_by"], ["id"], ondelete="CASCADE")
        batch.create_index("ix_password_link_made_by", ["made_by"])
    op.execute(
        "UPDATE password_link SET role = (SELECT account.role FROM account WHERE account.id = password_link.account_id)"
    )
    # Of earlier links nobody knows who made them: those of students who teach or assist somewhere may be of slips.
    op.execute(
        "DELETE FROM password_link WHERE role = 'student' AND account_id IN "
        "(SELECT account_id FROM membership WHERE role IN ('assistant', 'teacher'))"
    )
    with op.batch_alter_table("password_link") as batch:
        batch.alter_column("role", existing_type=sa.String(16), nullable=False)
    op.add_column("membership", sa.Column("is_confirmed", sa.Boolean(), nullable=True))
    op.execute(
        "UPDATE membership SET is_confirmed = (made_here OR ((family_name <> '' OR given_name <> '') AND "
        "account_id IN (SELECT id FROM account WHERE role <> 'guest')))"
    )
    with op.batch_alter_table("membership") as batch:
        batch.alter_column("is_confirmed", existing_type=sa.Boolean(), nullable=False)


def downgrade() -> None:
    op.drop_column("membership", "is_confirmed")
    with op.batch_alter_table("password_link") as batch:
        batch.drop_index("ix_password_link_made_by")
        batch.drop_constraint(MAKER, type_="foreignkey")
        for column in ("made_by", "class_id", "role"):
            batch.drop_column(column)
