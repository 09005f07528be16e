"""`balise admin …`: what administrators do by hand."""

from argparse import Namespace
from collections.abc import Mapping

from server.base import school_time
from server.base.errors import ServiceError
from server.cli import CommandError
from server.cli.admin import access, accounts, journal, mail, upkeep
from server.cli.admin.answer import Action
from server.cli.configuration import read_settings
from server.cli.database import open_database

ACTIONS: Mapping[str, Action] = {
    "accounts": accounts.list_accounts,
    "create": accounts.create_account,
    "disable": accounts.disable_account,
    "enable": accounts.enable_account,
    "erase": upkeep.erase_student_on_request,
    "invite": accounts.create_invitation_link,
    "log": journal.show_log,
    "mail": mail.test_and_report_mail,
    "purge": upkeep.erase_expired_students,
    "purge-guests": upkeep.purge_guests,
    "requeue": upkeep.requeue_submission,
    "reset-link": accounts.create_password_reset_link,
    "revoke": access.revoke_sessions_and_tokens,
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
            raise CommandError(refused.detail) from refused
    answer.show(arguments.json)
    return 0
