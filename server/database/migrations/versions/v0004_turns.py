"""turns: whose each job is, where it comes from, and when its turn comes

Jobs that wait already keep their order: each is a line of its own, and all have the same turn.
"""

import sqlalchemy as sa
from alembic import op

revision = "0004"
down_revision = "0003"
branch_labels = None
depends_on = None

TEXTS, NUMBERS = ("sender", "address", "line"), ("turn", "own_turn")
WAITS, LEASED = sa.text("lease_token IS NULL"), sa.text("lease_token IS NOT NULL")


def upgrade() -> None:
    op.drop_index("ix_job_claim", "job")
    with op.batch_alter_table("job") as table:
        for name in TEXTS:
            table.add_column(sa.Column(name, sa.String(length=300), nullable=False, server_default=""))
        for name in NUMBERS:
            table.add_column(sa.Column(name, sa.BigInteger(), nullable=False, server_default="0"))
    op.execute("UPDATE job SET sender = key, line = key")
    with op.batch_alter_table("job") as table:
        for name in TEXTS + NUMBERS:
            table.alter_column(name, server_default=None)
        table.drop_constraint("uq_job_kind_key", type_="unique")
        table.create_unique_constraint("uq_job_key_kind", ["key", "kind"])
    order = ["priority", "turn", "created_at", "id"]
    op.create_index("ix_job_claim", "job", order, sqlite_where=WAITS, postgresql_where=WAITS)
    op.create_index("ix_job_leased", "job", ["priority", "turn"], sqlite_where=LEASED, postgresql_where=LEASED)
    op.create_index("ix_job_line", "job", ["line"])
    op.create_index("ix_job_address", "job", ["address", "priority"], sqlite_where=WAITS, postgresql_where=WAITS)


def downgrade() -> None:
    for name in ("address", "line", "leased", "claim"):
        op.drop_index(f"ix_job_{name}", "job")
    with op.batch_alter_table("job") as table:
        for name in TEXTS + NUMBERS:
            table.drop_column(name)
        table.drop_constraint("uq_job_key_kind", type_="unique")
        table.create_unique_constraint("uq_job_kind_key", ["kind", "key"])
    op.create_index("ix_job_claim", "job", ["priority", "created_at", "id"])
