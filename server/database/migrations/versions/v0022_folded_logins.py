"""Logins in their folded form, except where another account has it

An account whose folded login is taken keeps the login that it has, and logs in with it.
"""

import unicodedata

import sqlalchemy as sa
from alembic import op

revision = "0022"
down_revision = "0021"
branch_labels = None
depends_on = None

LIGATURES = str.maketrans({"œ": "oe", "æ": "ae"})
ACCOUNT = sa.table("account", sa.column("id", sa.Uuid()), sa.column("login", sa.String()))


def _fold(login: str) -> str:
    """Fold as the version of this migration does."""
    for _ in range(4):
        seen = "".join(sign for sign in login if unicodedata.category(sign) != "Cf")
        folded = unicodedata.normalize("NFKC", seen).casefold().translate(LIGATURES)
        if folded == login:
            break
        login = folded
    return login


def upgrade() -> None:
    connection = op.get_bind()
    logins = {login for (login,) in connection.execute(sa.select(ACCOUNT.c.login)) if login is not None}
    for login in sorted(login for login in logins if not login.isascii()):
        folded = _fold(login)
        if folded not in logins and len(folded) in range(2, 255) and " " not in folded:
            connection.execute(sa.update(ACCOUNT).where(ACCOUNT.c.login == login).values(login=folded))
            logins = (logins - {login}) | {folded}


def downgrade() -> None:
    """Folded logins stay: they were valid before."""
