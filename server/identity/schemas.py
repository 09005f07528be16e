"""The forms of accounts, validated with messages in French."""

from dataclasses import dataclass

from server.base.errors import InvalidFields
from server.identity.logins import login_problem, normalise_login
from server.identity.passwords import password_problem
from server.text.lines import describe_forbidden_character, normalise_line

NAME_LENGTH = 100
LABEL_LENGTH = 100
NAME_PROBLEM = "Indiquez un nom de 1 à 100 caractères."


class RefusedForm(InvalidFields):
    """A form that cannot be accepted."""


@dataclass(frozen=True)
class NewAccount:
    """A name to show, a login (an e-mail address or a plain identifier, lower case), a password."""

    name: str
    login: str
    password: str


def validate_new_account(name: str, login: str, password: str) -> NewAccount:
    """Return the normalised form. Raises RefusedForm with every problem at once."""
    form = NewAccount(normalise_line(name), normalise_login(login), password)
    problems = {field: problem for field, problem in _account_problems(form) if problem}
    if problems:
        raise RefusedForm(problems)
    return form


def new_account_without_password(name: str, login: str) -> NewAccount:
    """Return the normalised form of an account whose owner chooses a password later. Raises RefusedForm."""
    form = NewAccount(normalise_line(name), normalise_login(login), "")
    problems = {field: problem for field, problem in _account_problems(form) if problem and field != "password"}
    if problems:
        raise RefusedForm(problems)
    return form


def _account_problems(form: NewAccount) -> list[tuple[str, str]]:
    return [
        ("name", _name_line_problem(form.name, NAME_LENGTH, NAME_PROBLEM)),
        ("login", login_problem(form.login)),
        ("password", password_problem(form.password, login=form.login, name=form.name)),
    ]


def validate_new_password(password: str, *, login: str, name: str) -> str:
    """Return the password. Raises RefusedForm where it is refused."""
    why = password_problem(password, login=login, name=name)
    if why:
        raise RefusedForm({"new_password": why})
    return password


def _name_line_problem(line: str, longest: int, problem: str) -> str:
    """Return why a tidied line is refused, or an empty text."""
    if not 0 < len(line) <= longest:
        return problem
    unwritable = describe_forbidden_character(line)
    return f"{unwritable[0].upper()}{unwritable[1:]}." if unwritable else ""


def validate_account_name(text: str) -> str:
    """Return the normalised name. Raises RefusedForm."""
    name = normalise_line(text)
    problem = _name_line_problem(name, NAME_LENGTH, NAME_PROBLEM)
    if problem:
        raise RefusedForm({"name": problem})
    return name


def validate_token_label(text: str) -> str:
    """Return the normalised name of an API token. Raises RefusedForm."""
    label = normalise_line(text)
    problem = _name_line_problem(label, LABEL_LENGTH, "Donnez au jeton un nom de 1 à 100 caractères.")
    if problem:
        raise RefusedForm({"label": problem})
    return label
