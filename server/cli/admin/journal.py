"""The audit log of the command line: each action that changes something is recorded with the system's user."""

import getpass
import os
from argparse import Namespace
from collections.abc import Mapping
from typing import Any

from sqlalchemy.orm import Session

from server.audit import repository
from server.audit import service as audit
from server.audit.models import AuditAction
from server.audit.wording import describe_changes
from server.base.settings import Settings
from server.cli.admin.answer import CommandAnswer
from server.database import Database
from server.identity.models import Account
from server.web.words import count_with_noun, format_iso_time, format_short_time


def record_action(
    db: Session,
    action: AuditAction,
    account: Account | None = None,
    *,
    before: Mapping[str, Any] | None = None,
    after: Mapping[str, Any] | None = None,
) -> None:
    """Record an action of the command line, in the transaction of the change."""
    subject = None if account is None else account.id
    audit.record_event(db, None, None, action, student=subject, about=_command_line(), before=before, after=after)


def record_action_in_own_transaction(
    database: Database, action: AuditAction, account: Account | None = None, *, after: Mapping[str, Any] | None = None
) -> None:
    """Record an action whose changes are made in transactions of their own."""
    with database.write() as db:
        record_action(db, action, account, after=after)


def _command_line() -> str:
    return f"ligne de commande, utilisateur {_system_user()}"


def _system_user() -> str:
    """Return the name of the system's user; in a container that names none, its number."""
    try:
        return getpass.getuser()
    except (KeyError, OSError):
        return str(os.getuid())


def show_log(database: Database, _settings: Settings, arguments: Namespace) -> CommandAnswer:
    """List the newest actions of administrators."""
    with database.read() as db:
        entries = repository.load_server_entries(db, limit=arguments.most)
        total = repository.count_server_entries(db)
    lines, data = [], []
    for entry in entries:
        changes = describe_changes(entry.before, entry.after, format_short_time)
        subject = f" : {entry.student.name}" if entry.student else ""
        author = f", par {entry.by.name}" if entry.by else ""
        details = f" ({' ; '.join(map(str, changes))})" if changes else ""
        lines.append(f"  {format_iso_time(entry.at)} {entry.words}{subject}{details}{author} [{entry.about}]")
        data.append(
            {
                "at": entry.at,
                "action": entry.what,
                "account": entry.student and entry.student.id,
                "by": entry.by and entry.by.id,
                "about": entry.about,
                "before": entry.before,
                "after": entry.after,
            }
        )
    shown = (
        f"{count_with_noun(len(entries), 'action')} sur {total}."
        if total > len(entries)
        else f"{count_with_noun(total, 'action')}."
    )
    return CommandAnswer([*lines, shown], {"actions": data, "total": total})
