"""`balise admin …`: what administrators do by hand."""

from argparse import Namespace
from collections.abc import Mapping

from server.base import school_time
from server.base.errors import ServiceError
from server.cli import CannotRun
from server.cli.admin import access, accounts, journal, mail, upkeep
from server.cli.admin.answer import Action
from server.cli.configuration import read_settings
from server.cli.database import opened

ACTIONS: Mapping[str, Action] = {
    "accounts": accounts.accounts,
    "create": accounts.create,
    "disable": accounts.disable,
    "enable": accounts.enable,
    "erase": upkeep.erase,
    "invite": accounts.invite,
    "log": journal.log,
    "mail": mail.mail,
    "purge": upkeep.purge,
    "purge-guests": upkeep.purge_guests,
    "requeue": upkeep.requeue,
    "reset-link": accounts.reset_link,
    "revoke": access.revoke,
    "role": accounts.role,
    "sessions": access.sessions,
    "standings": upkeep.standings,
    "tokens": access.listed_tokens,
}


def run(arguments: Namespace) -> int:
    settings = read_settings(data_dir=arguments.data)
    school_time.set_time_zone(settings.time_zone)
    with opened(settings) as database:
        try:
            answer = ACTIONS[arguments.action](database, settings, arguments)
        except ServiceError as refused:
            raise CannotRun(refused.detail) from refused
    answer.show(arguments.json)
    return 0
