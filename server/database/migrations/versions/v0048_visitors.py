"""By whom a student was seen in a lesson"""

import sqlalchemy as sa
from alembic import op

revision = "0048"
down_revision = "0047"
branch_labels = None
depends_on = None


def upgrade() -> None:
    with op.batch_alter_table("lesson_visit") as batch:
        batch.add_column(sa.Column("visited_by", sa.Uuid(), nullable=True))
        batch.create_foreign_key(
            op.f("fk_lesson_visit_visited_by_account"), "account", ["visited_by"], ["id"], ondelete="SET NULL"
        )
    op.create_index(op.f("ix_lesson_visit_visited_by"), "lesson_visit", ["visited_by"])


def downgrade() -> None:
    op.drop_index(op.f("ix_lesson_visit_visited_by"), "lesson_visit")
    with op.batch_alter_table("lesson_visit") as batch:
        batch.drop_constraint(op.f("fk_lesson_visit_visited_by_account"), type_="foreignkey")
        batch.drop_column("visited_by")
