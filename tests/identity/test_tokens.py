"""API tokens: a few, for a while, that say when they last served."""

from __future__ import annotations

import re
from datetime import timedelta
from typing import Any

import pytest
from sqlalchemy import select, update

from server.base.errors import NotFound
from server.base.settings import Settings
from server.database import Database, utc_now
from server.identity import links, service, tokens
from server.identity.models import Account, ApiToken
from tests.support.counting import Counted
from tests.support.service import Site, new_account

FORM = {"name": "Ada L.", "login": "ada", "password": "notes sur la machine"}


def test_both_databases_know_them_and_the_links(database: Database, both: Settings) -> None:
    account = new_account(database)
    with database.write() as db:
        db.execute(update(Account).values(login="ada"))
        _, secret = tokens.create_token(db, account, "essai", both)
        _, first = links.create_reset_link(db, "ada", both)
        _, second = links.create_reset_link(db, "ada", both)
    for _ in range(2):
        owner = tokens.find_token_owner(database, secret)
        assert owner is not None
        assert owner.id == account.id
    with database.write() as db:
        assert [token.last_used_at is not None for token in tokens.load_tokens(db, account)] == [True]
        assert links.consume_password_link(db, second).id == account.id
        for token in (first, second):
            with pytest.raises(NotFound):
                links.find_link_owner(db, token)
        service.delete_expired_credentials(db)


def create(site: Site, label: str = "portable") -> Any:
    return site.client.post("/compte/jetons", data={"label": label, "password": FORM["password"]})


def secret_of(page: Any) -> dict[str, str]:
    found = re.search(r'id="jeton">(balise_[\w-]{43})<', page.text)
    assert found
    return {"Authorization": f"Bearer {found[1]}"}


def use(site: Site, headers: dict[str, str]) -> int:
    return site.client.get("/api/v1/exercises", headers=headers).status_code


def stored(site: Site) -> list[ApiToken]:
    with site.database.read() as db:
        return list(db.execute(select(ApiToken)).scalars())


def change(site: Site, **values: object) -> None:
    with site.database.write() as db:
        db.execute(update(ApiToken).values(**values))


def test_an_account_has_a_few_and_a_revoked_one_makes_room(site: Site) -> None:
    site.tighten(api_tokens=2)
    site.client.post("/inscription", data=FORM)
    assert [create(site, f"n{number}").status_code for number in range(3)] == [200, 200, 422]
    page = create(site)
    assert "Vous avez déjà 2 jetons" in page.text
    assert len(stored(site)) == 2
    assert site.client.post(f"/compte/jetons/{stored(site)[0].id}/revoquer").status_code == 303
    assert create(site).status_code == 200


def test_a_token_ends_and_makes_room(site: Site) -> None:
    site.tighten(api_tokens=1)
    site.client.post("/inscription", data=FORM)
    page = create(site)
    headers, ends = secret_of(page), stored(site)[0].expires_at
    assert timedelta(days=364) < ends - utc_now() <= timedelta(days=365)
    assert f"valable jusqu’au {ends:%d/%m/%Y}" in page.text
    assert use(site, headers) == 200
    change(site, expires_at=utc_now() - timedelta(seconds=1))
    assert use(site, headers) == 401
    assert "Vous n’avez aucun jeton" in site.client.get("/compte").text
    assert create(site, "autre").status_code == 200
    change(site, expires_at=utc_now() - timedelta(seconds=1))
    with site.database.write() as db:
        service.delete_expired_credentials(db)
    assert stored(site) == []


def test_the_page_tells_when_a_token_last_served(site: Site) -> None:
    site.client.post("/inscription", data=FORM)
    headers = secret_of(create(site))
    assert "n’a pas encore servi" in site.client.get("/compte").text
    use(site, headers)
    assert f"a servi le {utc_now():%d/%m/%Y}" in site.client.get("/compte").text
    with Counted(site.database) as counted:
        use(site, headers)
    assert not [one for one in counted.statements if one.startswith("UPDATE")], "one use an hour is noted"
    before = utc_now() - 2 * tokens.LAST_USE_INTERVAL
    change(site, last_used_at=before)
    use(site, headers)
    (token,) = stored(site)
    assert token.last_used_at is not None
    assert token.last_used_at > before
