"""Parse the rows of a school's list of students, with the line number and the problem of each rejected row."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache

from server.base.errors import Invalid
from server.classes.models import EMAIL_LENGTH, NAME_LENGTH
from server.classes.sheets import SheetRow, read_rows
from server.identity.logins import is_valid_login, normalise_login

COLUMNS = ("nom", "prenom", "email", "identifiant", "groupe")
#: Column names of schools' programs, normalised by `normalise_name`.
COLUMN_ALIASES: Mapping[str, str] = {
    **{name: name for name in COLUMNS},
    "nom de famille": "nom", "nom eleve": "nom", "last name": "nom", "surname": "nom",
    "prenom eleve": "prenom", "prenoms": "prenom", "first name": "prenom",
    "e mail": "email", "mail": "email", "courriel": "email", "adresse electronique": "email", "adresse mail": "email",
    "adresse e mail": "email", "adresse email": "email", "email address": "email",
    "login": "identifiant", "id": "identifiant", "username": "identifiant", "nom d utilisateur": "identifiant",
    "groupes": "groupe", "group": "groupe", "groups": "groupe",
}  # fmt: skip
GROUP_LENGTH, MAX_GROUPS = 40, 8
EMAIL = re.compile(r"[^@\s]+@[^@\s]+\.[^@\s]+")

NO_HEADER = (
    "La première ligne doit nommer les colonnes : nom, prenom, email, identifiant, groupe "
    "(« nom » suffit ; leur ordre est libre)."
)


@dataclass(frozen=True)
class RosterLine:
    """One person of a list. An empty field keeps the known value."""

    line: int
    family_name: str = ""
    given_name: str = ""
    email: str = ""
    login: str = ""
    groups: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        return " ".join(filter(None, (self.given_name, self.family_name)))


@dataclass(frozen=True)
class RejectedLine:
    """A line that was refused, with its name and login as far as they could be read."""

    line: int
    reason: str
    name: str = ""
    login: str = ""


@dataclass(frozen=True)
class Roster:
    """A parsed list. `has_groups`: it has a column for groups, so that an empty cell means none."""

    rows: tuple[SheetRow, ...]
    lines: tuple[RosterLine, ...]
    rejected: tuple[RejectedLine, ...]
    ignored: tuple[str, ...]
    has_groups: bool


def normalise_name(text: str) -> str:
    """Fold accents, case and punctuation, so that two spellings of a name compare equal."""
    return _cached_fold(text) if len(text) <= NAME_LENGTH else _fold(text)


def _fold(text: str) -> str:
    plain = "".join(sign for sign in unicodedata.normalize("NFKD", text) if not unicodedata.combining(sign))
    return " ".join(re.findall(r"\w+", plain.casefold().replace("_", " ")))


_cached_fold = lru_cache(maxsize=8192)(_fold)


def read_roster(content: bytes) -> Roster:
    """Parse a file. Raises Invalid where it is no list at all, or Overloaded; bad lines are rejected one by one."""
    rows = read_rows(content)
    if not rows:
        raise Invalid("Cette liste est vide.")
    columns = _columns(rows[0])
    lines: list[RosterLine] = []
    rejected: list[RejectedLine] = []
    seen: dict[str, int] = {}
    for row in rows[1:]:
        line = _line(row, columns)
        try:
            _check(line, row, columns)
            _require_unique(line, seen)
        except Invalid as problem:
            rejected.append(RejectedLine(row.line, problem.detail, line.name, line.login))
        else:
            lines.append(line)
    ignored = tuple(cell.strip() for cell, column in zip(rows[0].cells, columns, strict=True) if not column and cell)
    return Roster(tuple(rows), tuple(lines), tuple(rejected), ignored, "groupe" in columns)


def _columns(header: SheetRow) -> Sequence[str]:
    """Return the column name of each header cell, empty where unknown."""
    columns = [COLUMN_ALIASES.get(normalise_name(cell), "") for cell in header.cells]
    named = [column for column in columns if column]
    if not {"nom", "prenom"} & set(named):
        raise Invalid(NO_HEADER)
    duplicate = next((name for name in named if named.count(name) > 1), None)
    if duplicate:
        raise Invalid(f"Ligne {header.line} : deux colonnes donnent « {duplicate} ».")
    return columns


def _line(row: SheetRow, columns: Sequence[str]) -> RosterLine:
    cells = {name: " ".join(cell.split()) for name, cell in zip(columns, row.cells, strict=False) if name}
    return RosterLine(
        line=row.line,
        family_name=cells.get("nom", ""),
        given_name=cells.get("prenom", ""),
        email=cells.get("email", "").casefold(),
        login=normalise_login(cells.get("identifiant", "")),
        groups=_labels(cells.get("groupe", "")),
    )


def _check(line: RosterLine, row: SheetRow, columns: Sequence[str]) -> None:
    """Raise Invalid for a malformed line."""
    if any(cell.strip() for cell in row.cells[len(columns) :]):
        raise Invalid("cette ligne a plus de cases que la première.")
    if not line.name:
        raise Invalid("il n’y a ni nom ni prénom.")
    if len(line.name) > NAME_LENGTH or not line.name.isprintable():
        raise Invalid(f"le nom dépasse {NAME_LENGTH} caractères, ou en a qui ne s’écrivent pas.")
    if line.email and (
        len(line.email) > EMAIL_LENGTH or not line.email.isprintable() or not EMAIL.fullmatch(line.email)
    ):
        raise Invalid(f"« {line.email[:60]} » n’est pas une adresse électronique.")
    if line.login and not is_valid_login(line.login):
        raise Invalid("l’identifiant compte de 2 à 254 caractères, sans espace.")
    check_groups(line.groups)


def parse_groups(text: str) -> tuple[str, ...]:
    """Parse labels separated by commas, semicolons or bars, without duplicates. Raises Invalid."""
    return check_groups(_labels(text))


def _labels(text: str) -> tuple[str, ...]:
    return tuple(dict.fromkeys(filter(None, (" ".join(piece.split()) for piece in re.split(r"[,;|]", text)))))


def check_groups(labels: tuple[str, ...]) -> tuple[str, ...]:
    """Return the labels. Raises Invalid where they are too many, or too long."""
    if len(labels) > MAX_GROUPS or any(len(label) > GROUP_LENGTH or not label.isprintable() for label in labels):
        raise Invalid(f"un élève a {MAX_GROUPS} groupes au plus, de {GROUP_LENGTH} caractères chacun.")
    return labels


def _require_unique(line: RosterLine, seen: dict[str, int]) -> None:
    """Raise Invalid for a person who stands in the list twice."""
    keys = [f"identifiant « {line.login} »"] if line.login else []
    keys += [f"adresse « {line.email} »"] if line.email else []
    if not keys:
        keys = [f"nom « {line.name} »"]
    for key in keys:
        earlier = seen.setdefault(normalise_name(key) if key.startswith("nom") else key, line.line)
        if earlier != line.line:
            raise Invalid(f"même {key} qu’à la ligne {earlier}.")
