"""`balise admin …` on accounts: making, finding, inviting, disabling, and the links that lead into them."""

from argparse import Namespace
from datetime import timedelta

from server.audit.models import AuditAction
from server.base.settings import Settings
from server.cli.admin import journal
from server.cli.admin.answer import ROLES, CommandAnswer, account_json, account_label
from server.database import Database
from server.identity import administration, links, repository
from server.identity.models import Role
from server.web.words import count_with_noun

BEHIND = "À mettre derrière l’adresse du service (--server URL l’ajoute)."


def create_account(database: Database, settings: Settings, arguments: Namespace) -> CommandAnswer:
    days = settings.first_password_days
    with database.write() as db:
        account = administration.create_account(db, arguments.login, arguments.name, Role(arguments.role))
        token = links.create_password_link(db, account, timedelta(days=days))
        journal.record_action(db, AuditAction.account_created, account, after={"role": account.role})
    label = f"{account_label(account)}, {ROLES[account.role]}"
    first = f"Compte créé : {label}. Son premier mot de passe se choisit par ce lien, qui"
    return _answer_with_link(
        f"{first} ne sert qu’une fois, pendant {count_with_noun(days, 'jour')} :",
        token,
        arguments,
        account_json(account),
    )


def create_password_reset_link(database: Database, settings: Settings, arguments: Namespace) -> CommandAnswer:
    with database.write() as db:
        account, token = links.create_reset_link(db, arguments.login, settings)
        journal.record_action(db, AuditAction.password_link_made, account)
    hours = count_with_noun(settings.password_link_hours, "heure")
    line = f"Pour {account_label(account)} : ce lien ne sert qu’une fois, et pendant {hours}."
    return _answer_with_link(line, token, arguments, account_json(account))


def create_invitation_link(database: Database, settings: Settings, arguments: Namespace) -> CommandAnswer:
    days = settings.first_password_days
    role = Role(arguments.role)
    with database.write() as db:
        token = links.create_invitation(db, role, timedelta(days=days))
        journal.record_action(db, AuditAction.invitation_made, after={"role": role})
    line = (
        f"Ce lien ouvre un compte d’{ROLES[role]} ; il ne sert qu’une fois, et pendant {count_with_noun(days, 'jour')}."
    )
    return _answer_with_link(line, token, arguments, {"role": role}, page="bienvenue")


def _answer_with_link(
    line: str, token: str, arguments: Namespace, data: dict[str, object], page: str = "nouveau-mot-de-passe"
) -> CommandAnswer:
    link = f"{arguments.server.rstrip('/')}/{page}/{token}"
    return CommandAnswer([line, link], {**data, "link": link}, "" if arguments.server else BEHIND)


def change_role(database: Database, _settings: Settings, arguments: Namespace) -> CommandAnswer:
    with database.write() as db:
        account = links.find_account_by_login_or_id(db, arguments.login)
        before = account.role
        administration.change_role(db, account, Role(arguments.role))
        journal.record_action(
            db, AuditAction.role_changed, account, before={"role": before}, after={"role": account.role}
        )
    return CommandAnswer([f"{account_label(account)} : {ROLES[account.role]}."], account_json(account))


def disable_account(database: Database, _settings: Settings, arguments: Namespace) -> CommandAnswer:
    with database.write() as db:
        account = links.find_account_by_login_or_id(db, arguments.login)
        administration.disable_account(db, account)
        journal.record_action(db, AuditAction.account_disabled, account)
    line = f"{account_label(account)} : suspendu. Ses sessions et ses jetons ont pris fin ; son travail reste."
    return CommandAnswer([line], account_json(account))


def enable_account(database: Database, _settings: Settings, arguments: Namespace) -> CommandAnswer:
    with database.write() as db:
        account = links.find_account_by_login_or_id(db, arguments.login)
        administration.enable_account(account)
        journal.record_action(db, AuditAction.account_enabled, account)
    return CommandAnswer(
        [f"{account_label(account)} : rétabli, avec le mot de passe qu’il avait."], account_json(account)
    )


def list_accounts(database: Database, _settings: Settings, arguments: Namespace) -> CommandAnswer:
    role = Role(arguments.role) if arguments.role else None
    with database.read() as db:
        found = repository.search_accounts(db, role=role, search=arguments.search, limit=arguments.most + 1)
    shown, more = found[: arguments.most], len(found) > arguments.most
    lines = [
        f"  {account_label(account)} : {ROLES[account.role]}{', suspendu' if account.disabled_at else ''}"
        for account in shown
    ]
    end = f"{count_with_noun(len(shown), 'compte')}{' ; il y en a d’autres (--most, --search)' if more else ''}."
    return CommandAnswer([*lines, end], {"accounts": [account_json(account) for account in shown], "more": more})
