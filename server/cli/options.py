"""The options of what administrators run: `balise top`, `backup`, `restore` and `admin`."""

import argparse
from collections.abc import Callable
from pathlib import Path

ROLES = ("student", "teacher", "administrator")
MAX_DAYS = 36500

Actions = Callable[[str, str], argparse.ArgumentParser]


def add_backup_options(parser: argparse.ArgumentParser) -> None:
    help_text = "fichier à faire, ou dossier où le faire (par défaut : ici, nommé d’après l’heure)"
    parser.add_argument("file", nargs="?", type=Path, metavar="FILE", help=help_text)
    _add_common_options(parser)


def add_restore_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("file", type=Path, metavar="FILE", help="fichier que « balise backup » a fait")
    how = parser.add_mutually_exclusive_group()
    how.add_argument("--replace", action="store_true", help="à la place de la base de données qui s’y trouve")
    how.add_argument("--check", action="store_true", help="vérifie seulement la sauvegarde")
    _add_common_options(parser)


def add_move_options(parser: argparse.ArgumentParser) -> None:
    help_text = "base de départ : postgresql://…, sqlite:///FICHIER, ou un dossier de données"
    parser.add_argument("source", metavar="FROM", help=help_text)
    parser.add_argument("target", metavar="TO", help="base d’arrivée, vide ou à créer, de même")
    parser.add_argument("--json", action="store_true", help="répond en JSON, pour un programme")


def add_top_options(parser: argparse.ArgumentParser) -> None:
    where = parser.add_mutually_exclusive_group()
    help_text = "adresse du service, lu avec le jeton d’un administrateur (sans elle : sa base de données)"
    where.add_argument("--server", metavar="URL", help=help_text)
    where.add_argument("--data", type=Path, metavar="DIR", help="dossier des données")
    parser.add_argument("--token", help="jeton (sans lui, BALISE_TOKEN, puis celui de « balise login »)")
    parser.add_argument("--once", action="store_true", help="une fois, sans rafraîchir")
    parser.add_argument("--json", action="store_true", help="une fois, en JSON, pour un programme")


def _add_common_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--data", type=Path, metavar="DIR", help="dossier des données")
    parser.add_argument("--json", action="store_true", help="répond en JSON, pour un programme")


def add_admin_options(parser: argparse.ArgumentParser) -> None:
    actions = parser.add_subparsers(dest="action", required=True, metavar="ACTION")

    def action(name: str, help_text: str) -> argparse.ArgumentParser:
        parser = actions.add_parser(name, help=help_text, description=f"{help_text[0].upper()}{help_text[1:]}.")
        _add_common_options(parser)
        return parser

    _add_account_commands(action)
    _add_access_commands(action)
    _add_upkeep_commands(action)
    log = action("log", "liste ce que les administrateurs ont fait, du plus récent au plus ancien")
    log.add_argument(
        "--most", type=parse_positive_integer, default=200, metavar="N", help="au plus (par défaut : %(default)s)"
    )
    mail = action("mail", "dit les réglages des courriels et leurs derniers échecs, et en envoie un d’essai")
    mail.add_argument("--to", metavar="ADRESSE", help="adresse qui reçoit le courriel d’essai")


def _add_account_commands(action: Actions) -> None:
    create = action("create", "crée un compte, et donne le lien qui en choisit le premier mot de passe")
    _add_login_argument(create)
    create.add_argument("--name", required=True, metavar="NOM", help="nom, comme il est montré")
    create.add_argument("--role", choices=ROLES, default="student", help="rôle (par défaut : %(default)s)")
    _add_server_option(create)
    invite = action("invite", "donne un lien, qui ne sert qu’une fois, pour ouvrir un compte d’enseignant")
    invite.add_argument("--role", choices=ROLES[1:], default="teacher", help="rôle (par défaut : %(default)s)")
    _add_server_option(invite)
    reset = action("reset-link", "donne un lien, qui ne sert qu’une fois, pour choisir un nouveau mot de passe")
    _add_login_argument(reset)
    _add_server_option(reset)
    role = action("role", "donne un rôle à un compte : student, teacher ou administrator")
    _add_login_argument(role)
    role.add_argument("role", metavar="ROLE", choices=ROLES, help="son nouveau rôle")
    _add_login_argument(action("disable", "suspend un compte : plus personne n’y entre, son travail reste"))
    _add_login_argument(action("enable", "rétablit un compte suspendu"))
    accounts = action("accounts", "liste les comptes qui ont un identifiant")
    accounts.add_argument("--role", choices=ROLES, help="seulement ceux de ce rôle")
    accounts.add_argument(
        "--search", default="", metavar="TEXTE", help="seulement ceux dont l’identifiant ou le nom l’a"
    )
    accounts.add_argument(
        "--most", type=parse_positive_integer, default=200, metavar="N", help="au plus (par défaut : %(default)s)"
    )


def _add_access_commands(action: Actions) -> None:
    _add_login_argument(action("sessions", "liste les sessions ouvertes d’un compte"))
    _add_login_argument(action("tokens", "liste les jetons d’un compte"))
    revoke = action("revoke", "ferme des sessions et révoque des jetons d’un compte")
    _add_login_argument(revoke)
    help_text = "session ou jeton, comme « sessions » et « tokens » les nomment"
    revoke.add_argument("names", nargs="*", metavar="NAME", help=help_text)
    revoke.add_argument("--all", action="store_true", help="tous")


def _add_upkeep_commands(action: Actions) -> None:
    erase = action("erase", "dit ce qui disparaît avec un élève qui le demande, ou l’efface")
    _add_login_argument(erase)
    _add_yes_option(erase)
    erase.add_argument("--cancel", action="store_true", help="annule un effacement qui attend un contrôle")
    action("standings", "refait les bilans (meilleure note, nombre d’essais) d’après l’historique des corrections")
    purge = action("purge", "dit quels comptes d’élèves dépassent la durée de conservation réglée, ou les efface")
    _add_yes_option(purge)
    guests = action("purge-guests", "dit combien d’invités n’ont rien envoyé, ou les efface")
    guests.add_argument(
        "--days",
        type=parse_day_count,
        default=7,
        metavar="N",
        help="venus il y a plus de N jours (par défaut : %(default)s)",
    )
    _add_yes_option(guests)
    requeue = action("requeue", "remet à corriger les essais que plus rien ne corrige")
    requeue.add_argument("submissions", nargs="*", metavar="SUBMISSION", help="ces essais seulement")
    requeue.add_argument("--failed", action="store_true", help="ceux aussi dont la correction a échoué de notre côté")


def _add_login_argument(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("login", metavar="LOGIN", help="identifiant du compte")


def _add_server_option(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--server", metavar="URL", default="", help="adresse publique du service, à mettre devant le lien"
    )


def _add_yes_option(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--yes", action="store_true", help="les efface, pour de bon")


def parse_positive_integer(text: str) -> int:
    return max(1, parse_bounded_integer(text, 100_000, "ce nombre"))


def parse_day_count(text: str) -> int:
    return parse_bounded_integer(text, MAX_DAYS, "le nombre de jours")


def parse_bounded_integer(text: str, maximum: int, unit: str) -> int:
    if not text.isascii() or not text.isdigit() or int(text) > maximum:
        raise argparse.ArgumentTypeError(f"{unit} doit être un entier de 0 à {maximum}")
    return int(text)
