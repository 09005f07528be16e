"""`balise admin …` on what opens an account: its browser sessions and its API tokens."""

from argparse import Namespace
from datetime import datetime

from server.audit.models import AuditAction
from server.base.errors import NotFound
from server.base.settings import Settings
from server.base.validation import parse_uuid
from server.cli import CommandError
from server.cli.admin import journal
from server.cli.admin.answer import CommandAnswer, account_json, account_label
from server.database import Database
from server.identity import administration, links, repository, tokens
from server.identity.models import ApiToken, BrowserSession
from server.web.words import count_with_noun, format_iso_time

#: A session's name is a prefix of its token digest: enough to identify it, useless to authenticate.
NAME_LENGTH = 12
UNKNOWN = "{login} n’a ni session ni jeton « {name} »."


def list_sessions(database: Database, _settings: Settings, arguments: Namespace) -> CommandAnswer:
    with database.read() as db:
        account = links.find_account_by_login_or_id(db, arguments.login)
        open_sessions = repository.load_sessions(db, account.id)
    lines = [
        f"  {_session_name(session)} : depuis {format_iso_time(session.created_at)}, "
        f"jusqu’à {format_iso_time(session.expires_at)}"
        for session in open_sessions
    ]
    end = f"{account_label(account)} : {count_with_noun(len(open_sessions), 'session ouverte', 'sessions ouvertes')}."
    return CommandAnswer(
        [*lines, end], {**account_json(account), "sessions": [_session_json(session) for session in open_sessions]}
    )


def list_tokens(database: Database, _settings: Settings, arguments: Namespace) -> CommandAnswer:
    with database.read() as db:
        account = links.find_account_by_login_or_id(db, arguments.login)
        api_tokens = tokens.load_tokens(db, account)
    lines = [f"  {token.id} : « {token.label} », {_last_use_in_words(token.last_used_at)}" for token in api_tokens]
    end = f"{account_label(account)} : {count_with_noun(len(api_tokens), 'jeton')}."
    return CommandAnswer(
        [*lines, end], {**account_json(account), "tokens": [_token_json(token) for token in api_tokens]}
    )


def revoke_sessions_and_tokens(database: Database, _settings: Settings, arguments: Namespace) -> CommandAnswer:
    """Revoke sessions and tokens: the named ones, or all of them."""
    if bool(arguments.names) == arguments.all:
        raise CommandError("nommez ce qui est à révoquer (voyez « sessions » et « tokens »), ou --all pour tout.")
    with database.write() as db:
        account = links.find_account_by_login_or_id(db, arguments.login)
        if arguments.all:
            count = len(repository.load_sessions(db, account.id)) + len(repository.load_all_tokens(db, account.id))
            repository.delete_sessions_of(db, account.id)
            repository.delete_tokens_of(db, account.id)
        else:
            count = len(arguments.names)
            for name in arguments.names:
                if len(name) == NAME_LENGTH and administration.revoke_sessions_by_digest_prefix(db, account, name):
                    continue
                missing = UNKNOWN.format(login=account.handle, name=name)
                try:
                    tokens.revoke_token(db, account, parse_uuid(name, missing))
                except NotFound as error:
                    raise NotFound(missing) from error
        journal.record_action(db, AuditAction.access_revoked, account, after={"accesses": count})
    return CommandAnswer(
        [f"{account_label(account)} : {count_with_noun(count, 'accès révoqué', 'accès révoqués')}."], {"revoked": count}
    )


def _session_name(session: BrowserSession) -> str:
    return session.token_digest[:NAME_LENGTH]


def _session_json(session: BrowserSession) -> dict[str, object]:
    return {"id": _session_name(session), "created_at": session.created_at, "expires_at": session.expires_at}


def _token_json(token: ApiToken) -> dict[str, object]:
    times = {"created_at": token.created_at, "expires_at": token.expires_at, "last_used_at": token.last_used_at}
    return {"id": token.id, "label": token.label, **times}


def _last_use_in_words(when: datetime | None) -> str:
    return "jamais utilisé" if when is None else f"utilisé pour la dernière fois {format_iso_time(when)}"
