"""`balise admin …`: what administrators do by hand."""

from argparse import Namespace
from collections.abc import Mapping

from server.base import school_time
from server.base.errors import ServiceError
from server.cli import CannotRun
from server.cli.admin import access, accounts, journal, mail, upkeep
from server.cli.admin.answer import Action
from server.cli.configuration import read_settings
from server.cli.database import open_database

ACTIONS: Mapping[str, Action] = {
    "accounts": accounts.list_accounts,
    "create": accounts.create,
    "disable": accounts.disable,
    "enable": accounts.enable,
    "erase": upkeep.erase,
    "invite": accounts.invite,
    "log": journal.show_log,
    "mail": mail.mail,
    "purge": upkeep.purge,
    "purge-guests": upkeep.purge_guests,
    "requeue": upkeep.requeue,
    "reset-link": accounts.reset_link,
    "revoke": access.revoke,
    "role": accounts.change_role,
    "sessions": access.list_sessions,
    "standings": upkeep.recount_standings,
    "tokens": access.list_tokens,
}


def run(arguments: Namespace) -> int:
    settings = read_settings(data_dir=arguments.data)
    school_time.set_time_zone(settings.time_zone)
    with open_database(settings) as database:
        try:
            answer = ACTIONS[arguments.action](database, settings, arguments)
        except ServiceError as refused:
            raise CannotRun(refused.detail) from refused
    answer.show(arguments.json)
    return 0
