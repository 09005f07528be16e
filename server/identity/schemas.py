"""What the forms of the accounts hold, checked with messages in French."""

from dataclasses import dataclass

from server.base.errors import InvalidFields
from server.identity.passwords import password_problem

LOGIN_LENGTH = range(2, 255)
NAME_LENGTH = 100
LABEL_LENGTH = 100


class RefusedForm(InvalidFields):
    """A form that cannot be accepted."""


@dataclass(frozen=True)
class NewAccount:
    """A name to show, a login (an e-mail address or a plain identifier, lower case), a password."""

    name: str
    login: str
    password: str


def normalise_login(text: str) -> str:
    return text.strip().casefold()


def validate_new_account(name: str, login: str, password: str) -> NewAccount:
    """Reads the form, or raises RefusedForm with every problem at once."""
    wanted = NewAccount(" ".join(name.split()), normalise_login(login), password)
    problems = {field: problem for field, problem in _checks(wanted) if problem}
    if problems:
        raise RefusedForm(problems)
    return wanted


def new_account_without_password(name: str, login: str) -> NewAccount:
    """The same for an account of which the owner chooses a password later."""
    wanted = NewAccount(" ".join(name.split()), normalise_login(login), "")
    problems = {field: problem for field, problem in _checks(wanted) if problem and field != "password"}
    if problems:
        raise RefusedForm(problems)
    return wanted


def _checks(wanted: NewAccount) -> list[tuple[str, str]]:
    return [
        ("name", "" if _printable(wanted.name, NAME_LENGTH) else "Indiquez un nom de 1 à 100 caractères."),
        ("login", "" if is_valid_login(wanted.login) else "L’identifiant compte de 2 à 254 caractères, sans espace."),
        ("password", password_problem(wanted.password, login=wanted.login, name=wanted.name)),
    ]


def validate_new_password(password: str, *, login: str, name: str) -> str:
    """The password that this person may have from now on, or raises RefusedForm."""
    why = password_problem(password, login=login, name=name)
    if why:
        raise RefusedForm({"new_password": why})
    return password


def _printable(text: str, longest: int) -> bool:
    return 0 < len(text) <= longest and text.isprintable()


def is_valid_login(login: str) -> bool:
    return len(login) in LOGIN_LENGTH and login.isprintable() and " " not in login


def validate_token_label(text: str) -> str:
    """The name that a person gives to an API token."""
    label = " ".join(text.split())
    if not _printable(label, LABEL_LENGTH):
        raise RefusedForm({"label": "Donnez au jeton un nom de 1 à 100 caractères."})
    return label
