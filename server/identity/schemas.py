"""What the forms of the accounts hold, checked with messages in French."""

from dataclasses import dataclass

from server.base.errors import Invalid

LOGIN_LENGTH = range(2, 255)
PASSWORD_LENGTH = range(8, 1025)
NAME_LENGTH = 100
LABEL_LENGTH = 100


class RefusedForm(Invalid):
    """A form that cannot be accepted; `problems` maps a field's name to a sentence."""

    def __init__(self, problems: dict[str, str]) -> None:
        super().__init__(" ".join(problems.values()))
        self.problems = problems


@dataclass(frozen=True)
class NewAccount:
    """A name to show, a login (an e-mail address or a plain identifier, lower case), a password."""

    name: str
    login: str
    password: str


def normalised_login(text: str) -> str:
    return text.strip().casefold()


def new_account(name: str, login: str, password: str) -> NewAccount:
    """Reads the form, or raises RefusedForm with every problem at once."""
    wanted = NewAccount(" ".join(name.split()), normalised_login(login), password)
    problems = {field: problem for field, problem in _checks(wanted) if problem}
    if problems:
        raise RefusedForm(problems)
    return wanted


def _checks(wanted: NewAccount) -> list[tuple[str, str]]:
    return [
        ("name", "" if _printable(wanted.name, NAME_LENGTH) else "Indiquez un nom de 1 à 100 caractères."),
        ("login", "" if _valid_login(wanted.login) else "L’identifiant compte de 2 à 254 caractères, sans espace."),
        ("password", _password_problem(wanted.password)),
    ]


def _printable(text: str, longest: int) -> bool:
    return 0 < len(text) <= longest and text.isprintable()


def _valid_login(login: str) -> bool:
    return len(login) in LOGIN_LENGTH and login.isprintable() and " " not in login


def _password_problem(password: str) -> str:
    if len(password) < PASSWORD_LENGTH.start:
        return f"Le mot de passe compte au moins {PASSWORD_LENGTH.start} caractères."
    return "" if len(password) < PASSWORD_LENGTH.stop else "Le mot de passe est trop long."


def token_label(text: str) -> str:
    """The name that a person gives to an API token."""
    label = " ".join(text.split())
    if not _printable(label, LABEL_LENGTH):
        raise RefusedForm({"label": "Donnez au jeton un nom de 1 à 100 caractères."})
    return label
