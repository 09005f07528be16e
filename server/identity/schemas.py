"""The forms of accounts, validated with messages in French."""

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
    """Return the normalised form. Raises RefusedForm with every problem at once."""
    form = NewAccount(" ".join(name.split()), normalise_login(login), password)
    problems = {field: problem for field, problem in _checks(form) if problem}
    if problems:
        raise RefusedForm(problems)
    return form


def new_account_without_password(name: str, login: str) -> NewAccount:
    """Return the normalised form of an account whose owner chooses a password later. Raises RefusedForm."""
    form = NewAccount(" ".join(name.split()), normalise_login(login), "")
    problems = {field: problem for field, problem in _checks(form) if problem and field != "password"}
    if problems:
        raise RefusedForm(problems)
    return form


def _checks(form: NewAccount) -> list[tuple[str, str]]:
    return [
        ("name", "" if _printable(form.name, NAME_LENGTH) else "Indiquez un nom de 1 à 100 caractères."),
        ("login", "" if is_valid_login(form.login) else "L’identifiant compte de 2 à 254 caractères, sans espace."),
        ("password", password_problem(form.password, login=form.login, name=form.name)),
    ]


def validate_new_password(password: str, *, login: str, name: str) -> str:
    """Return the password. Raises RefusedForm where it is refused."""
    why = password_problem(password, login=login, name=name)
    if why:
        raise RefusedForm({"new_password": why})
    return password


def _printable(text: str, longest: int) -> bool:
    return 0 < len(text) <= longest and text.isprintable()


def is_valid_login(login: str) -> bool:
    return len(login) in LOGIN_LENGTH and login.isprintable() and " " not in login


def validate_token_label(text: str) -> str:
    """Return the normalised name of an API token. Raises RefusedForm."""
    label = " ".join(text.split())
    if not _printable(label, LABEL_LENGTH):
        raise RefusedForm({"label": "Donnez au jeton un nom de 1 à 100 caractères."})
    return label
