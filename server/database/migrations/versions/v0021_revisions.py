"""Revisions: a graded attempt has a number that is drawn anew each time that something of it changes"""

import sqlalchemy as sa
from alembic import op

revision = "0021"
down_revision = "0020"
branch_labels = None
depends_on = None

READ = "account_id, exercise, digest, created_at, grading_id"
FOUND = "submission_id, outcome, score, diagnosis"
INDEX, COLUMN = "ix_submission_revisions", "revision"

#: Sixty bits, of both databases: of no number but those that are drawn, so that what was rolled back does not return.
SQLITE_DRAWN = "(random() & 1152921504606846975)"
SQLITE = (
    f"""CREATE TRIGGER submission_revised_at_first AFTER INSERT ON submission
    WHEN NEW.grading_id IS NOT NULL AND NEW.revision IS NULL
    BEGIN UPDATE submission SET revision = {SQLITE_DRAWN} WHERE id = NEW.id; END""",
    f"""CREATE TRIGGER submission_revised AFTER UPDATE OF {READ} ON submission
    BEGIN
        UPDATE submission SET revision = CASE WHEN grading_id IS NULL THEN NULL ELSE {SQLITE_DRAWN} END
        WHERE id = NEW.id;
    END""",
    f"""CREATE TRIGGER grading_revised AFTER UPDATE OF {FOUND} ON grading
    BEGIN UPDATE submission SET revision = {SQLITE_DRAWN} WHERE grading_id = NEW.id; END""",
)

POSTGRESQL_DRAWN = """CREATE OR REPLACE FUNCTION balise_revision() RETURNS bigint LANGUAGE sql VOLATILE AS $$
    SELECT ('x0' || right(replace(gen_random_uuid()::text, '-', ''), 15))::bit(64)::bigint
$$"""
POSTGRESQL = (
    """CREATE OR REPLACE FUNCTION balise_submission_revised() RETURNS trigger LANGUAGE plpgsql AS $$
    BEGIN
        NEW.revision := CASE WHEN NEW.grading_id IS NULL THEN NULL ELSE balise_revision() END;
        RETURN NEW;
    END
    $$""",
    """CREATE OR REPLACE FUNCTION balise_grading_revised() RETURNS trigger LANGUAGE plpgsql AS $$
    BEGIN
        UPDATE submission SET revision = balise_revision() WHERE grading_id = NEW.id;
        RETURN NULL;
    END
    $$""",
    """CREATE TRIGGER submission_revised_at_first BEFORE INSERT ON submission FOR EACH ROW
    WHEN (NEW.grading_id IS NOT NULL AND NEW.revision IS NULL) EXECUTE FUNCTION balise_submission_revised()""",
    f"""CREATE TRIGGER submission_revised BEFORE UPDATE OF {READ} ON submission FOR EACH ROW
    EXECUTE FUNCTION balise_submission_revised()""",
    f"""CREATE TRIGGER grading_revised AFTER UPDATE OF {FOUND} ON grading FOR EACH ROW
    EXECUTE FUNCTION balise_grading_revised()""",
)


def upgrade() -> None:
    op.add_column("submission", sa.Column(COLUMN, sa.BigInteger(), nullable=True))
    sqlite = op.get_bind().dialect.name == "sqlite"
    if not sqlite:
        op.execute(POSTGRESQL_DRAWN)
    drawn = SQLITE_DRAWN if sqlite else "balise_revision()"
    op.execute(f"UPDATE submission SET revision = {drawn} WHERE grading_id IS NOT NULL")
    known = sa.text("revision IS NOT NULL")
    op.create_index(INDEX, "submission", ["account_id", COLUMN], sqlite_where=known, postgresql_where=known)
    for statement in SQLITE if sqlite else POSTGRESQL:
        op.execute(statement)


def downgrade() -> None:
    of = {"submission_revised_at_first": "submission", "submission_revised": "submission", "grading_revised": "grading"}
    sqlite = op.get_bind().dialect.name == "sqlite"
    for trigger, table in of.items():
        op.execute(f"DROP TRIGGER {trigger}" if sqlite else f"DROP TRIGGER {trigger} ON {table}")
    if not sqlite:
        for function in ("balise_grading_revised", "balise_submission_revised", "balise_revision"):
            op.execute(f"DROP FUNCTION {function}()")
    op.drop_index(INDEX, "submission")
    op.drop_column("submission", COLUMN)
