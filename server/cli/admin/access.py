"""`balise admin …` on what opens an account: its browser sessions and its API tokens."""

from argparse import Namespace
from datetime import datetime

from server.base.errors import NotFound
from server.base.settings import Settings
from server.base.validation import parse_uuid
from server.cli import CannotRun
from server.cli.admin.answer import Answer, told, who
from server.database import Database
from server.identity import links, repository, service, tokens
from server.identity.models import ApiToken, BrowserSession
from server.web.words import iso_moment, plural

#: A session is named by the beginning of what is kept of its token: enough to tell it, of no use to enter.
NAME_LENGTH = 12
UNKNOWN = "{login} n’a ni session ni jeton « {name} »."


def sessions(database: Database, _settings: Settings, arguments: Namespace) -> Answer:
    with database.read() as db:
        account = links.find_account_by_login(db, arguments.login)
        found = repository.load_sessions(db, account.id)
    lines = [
        f"  {_name(one)} : depuis {iso_moment(one.created_at)}, jusqu’à {iso_moment(one.expires_at)}" for one in found
    ]
    end = f"{who(account)} : {plural(len(found), 'session ouverte', 'sessions ouvertes')}."
    return Answer([*lines, end], {**told(account), "sessions": [_session(one) for one in found]})


def listed_tokens(database: Database, _settings: Settings, arguments: Namespace) -> Answer:
    with database.read() as db:
        account = links.find_account_by_login(db, arguments.login)
        found = tokens.load_tokens(db, account)
    lines = [f"  {one.id} : « {one.label} », {_served(one.last_used_at)}" for one in found]
    end = f"{who(account)} : {plural(len(found), 'jeton')}."
    return Answer([*lines, end], {**told(account), "tokens": [_token(one) for one in found]})


def revoke(database: Database, _settings: Settings, arguments: Namespace) -> Answer:
    """Those that are named, or all of them: sessions and tokens alike."""
    if bool(arguments.names) == arguments.all:
        raise CannotRun("nommez ce qui est à révoquer (voyez « sessions » et « tokens »), ou --all pour tout.")
    with database.write() as db:
        account = links.find_account_by_login(db, arguments.login)
        if arguments.all:
            count = len(repository.load_sessions(db, account.id)) + len(repository.load_all_tokens(db, account.id))
            repository.delete_sessions_of(db, account.id)
            repository.delete_tokens_of(db, account.id)
        else:
            count = len(arguments.names)
            for name in arguments.names:
                if len(name) == NAME_LENGTH and service.revoke_session(db, account, name):
                    continue
                missing = UNKNOWN.format(login=account.login, name=name)
                try:
                    tokens.revoke_token(db, account, parse_uuid(name, missing))
                except NotFound as error:
                    raise NotFound(missing) from error
    return Answer([f"{who(account)} : {plural(count, 'accès révoqué', 'accès révoqués')}."], {"revoked": count})


def _name(one: BrowserSession) -> str:
    return one.token_digest[:NAME_LENGTH]


def _session(one: BrowserSession) -> dict[str, object]:
    return {"id": _name(one), "created_at": one.created_at, "expires_at": one.expires_at}


def _token(one: ApiToken) -> dict[str, object]:
    times = {"created_at": one.created_at, "expires_at": one.expires_at, "last_used_at": one.last_used_at}
    return {"id": one.id, "label": one.label, **times}


def _served(when: datetime | None) -> str:
    return "jamais utilisé" if when is None else f"utilisé pour la dernière fois {iso_moment(when)}"
