"""Read the rows of a list as people, and say what is wrong with each, in French."""

from __future__ import annotations

import re
import unicodedata

from graders.typography import limit_marks
from server.base.errors import Invalid
from server.classes.columns import RosterHeader
from server.classes.encodings import find_damaged_word
from server.classes.folding import normalise_name
from server.classes.full_names import split_full_name
from server.classes.headers import KNOWN_TO_STUDENTS, RosterField
from server.classes.models import EMAIL_LENGTH, NAME_LENGTH
from server.classes.roster_line import RosterLine, require_valid_labels, split_group_labels
from server.classes.rows import SheetRow
from server.classes.sheets import SheetReading
from server.classes.spreadsheet import FORMULA
from server.identity.logins import login_problem, normalise_login
from server.text.lines import describe_forbidden_character, normalise_line

EMAIL = re.compile(r"[^@\s<>,;]+@[^@\s<>,;]+\.[^@\s<>,;]+")
#: The last lines of an export, which count or sign it.
FOOTER = re.compile(r"(?:total|effectif|nombre|page|edite|imprime|export|genere|liste)\b.*(?:\d|:)", re.IGNORECASE)
SUMS = frozenset({"total", "totaux", "effectif", "effectif total", "total eleves", "nombre d eleves"})
SHEET_ERROR = re.compile(r"#(?:N/A|REF!|VALUE!|VALEUR!|DIV/0!|NAME\?|NOM\?|NUM!|NOMBRE!|NULL!|NUL!)")
MAX_NAMED_LINES = 5
FORMULA_CELL = (
    "la cellule {cell} est une formule sans valeur : ouvrez puis enregistrez le classeur dans votre tableur, et "
    "reprenez le fichier."
)
ERROR_CELL = "une case contient une erreur de tableur ({text})."
DAMAGED = (
    "les accents de « {word} » sont abîmés : le fichier a été enregistré dans un autre encodage. Corrigez cette ligne, "
    "ou choisissez comment les accents sont lus."
)
WHOLE_NAMES = (
    "{count} noms complets ne se coupent pas sûrement en nom et prénom, et restent entiers (lignes {lines}) : dites "
    "l’ordre de la colonne, ou mettez en capitales les noms de famille seulement."
)
WHOLE_NAME = (
    "Un nom complet ne se coupe pas sûrement en nom et prénom, et reste entier (ligne {lines}) : dites l’ordre de la "
    "colonne, ou mettez en capitales le nom de famille seulement."
)
REPAIRED = "Les accents de ce fichier étaient abîmés : « {before} » est lu « {after} », et de même ailleurs."
UNUSUAL = "Les accents sont lus comme écrits par {used}."
RARE = frozenset({"iso8859_15", "mac_roman", "cp850"})
GUESSED = "Les accents sont lus comme écrits par {used}, mais ce peut être {others} : vérifiez les noms."


#: Whether the family name comes first, where the header says so.
FULL_NAME_ORDERS = {RosterField.full_name: True, RosterField.reversed_name: False, RosterField.complete_name: None}
ENCODING_WORDS = {
    "cp1252": "Windows", "iso8859_15": "un ancien Unix", "mac_roman": "un ancien Mac", "cp850": "MS-DOS",
    "utf-8": "un programme d’aujourd’hui (UTF-8)", "utf-16": "Excel (UTF-16)",
}  # fmt: skip


class LineReader:
    """Reads the rows of one list, one after the other: a person stands in it once."""

    def __init__(self, header: RosterHeader) -> None:
        self._columns = {name: header.columns_of(name) for name in RosterField}
        self._width = len(header.columns)
        self._seen: dict[str, int] = {}
        self._namesakes: dict[str, list[tuple[str, int]]] = {}
        self._whole: list[int] = []
        self._used = [column.index for column in header.columns if column.field]
        self._number_is_login = not self._columns[RosterField.login] and not self._columns[RosterField.email]

    def read_line(self, row: SheetRow) -> RosterLine:
        family, given, is_whole = self._read_names(row)
        if is_whole:
            self._whole.append(row.line)
        login = self._first_filled_cell(row, RosterField.login)
        number = self._first_filled_cell(row, RosterField.number)
        if self._number_is_login and number and self._columns[RosterField.number][0].rank == KNOWN_TO_STUDENTS:
            login = number
        return RosterLine(
            line=row.line,
            family_name=family,
            given_name=self._usual_given_name(given),
            email=_extract_email(self._first_filled_cell(row, RosterField.email)),
            login=normalise_login(login),
            groups=self._read_groups(row),
            school_class=self._first_filled_cell(row, RosterField.school_class),
            key=" ".join(filter(None, (number, self._first_filled_cell(row, RosterField.birth)))),
        )

    def _first_filled_cell(self, row: SheetRow, name: RosterField) -> str:
        """Return the first filled cell among the columns of a field, in the order in which they count."""
        cells = (_tidy_cell(row, column.index) for column in self._columns[name])
        return next(filter(None, cells), "")

    def _read_names(self, row: SheetRow) -> tuple[str, str, bool]:
        """Return family and given name, and whether a full name stays whole. The usual name goes first."""
        family, given = (
            self._first_filled_cell(row, RosterField.family),
            self._first_filled_cell(row, RosterField.given),
        )
        for full, family_first in FULL_NAME_ORDERS.items():
            text = self._first_filled_cell(row, full)
            if text and not family and not given:
                split = split_full_name(text, family_first)
                return split.family, split.given, split.whole
        if family and not given and not self._columns[RosterField.given]:
            split = split_full_name(family)
            return split.family, split.given, False
        return family, given, False

    def _usual_given_name(self, given: str) -> str:
        """Return the first of « Inès, Marie » in a column of all given names."""
        columns = self._columns[RosterField.given]
        return given.split(",", maxsplit=1)[0].strip() if columns and columns[0].rank == 1 else given

    def _read_groups(self, row: SheetRow) -> tuple[str, ...]:
        columns = self._columns[RosterField.group]
        labels: list[str] = []
        for column in columns:
            for label in split_group_labels(_tidy_cell(row, column.index)):
                is_bare = len(columns) > 1 and not re.search(r"[^\W\d_]{2}|[^\W\d_]\d", label)
                labels.append(f"{column.qualifier} {label}".strip() if is_bare else label)
        return tuple(dict.fromkeys(labels))

    def require_well_formed(self, line: RosterLine, row: SheetRow) -> None:
        """Raise Invalid for a malformed line."""
        if any(normalise_line(cell) for cell in row.cells[self._width :]):
            raise Invalid("cette ligne a plus de cases que la première.")
        cells = [normalise_line(row.cells[index]) for index in self._used if index < len(row.cells)]
        formula = next((cell.removeprefix(FORMULA) for cell in cells if cell.startswith(FORMULA)), "")
        if formula:
            raise Invalid(FORMULA_CELL.format(cell=formula))
        error = next((cell for cell in cells if SHEET_ERROR.fullmatch(cell)), "")
        if error:
            raise Invalid(ERROR_CELL.format(text=error))
        is_alone = sum(bool(normalise_line(cell)) for cell in row.cells) == 1
        problem = _name_problem(line.name, is_alone)
        if problem:
            raise Invalid(problem)
        damaged = find_damaged_word(f"{line.name} {' '.join(line.groups)}")
        if damaged:
            raise Invalid(DAMAGED.format(word=damaged))
        for what, text in (("le nom", line.name), ("l’adresse", line.email), ("les groupes", " ".join(line.groups))):
            unwritable = describe_forbidden_character(text)
            if unwritable:
                raise Invalid(f"dans {what}, {unwritable}.")
        if line.email and (len(line.email) > EMAIL_LENGTH or not EMAIL.fullmatch(line.email)):
            raise Invalid(f"« {line.email[:60]} » n’est pas une adresse électronique.")
        problem = login_problem(line.account_login) if line.account_login else ""
        if problem:
            raise Invalid(f"{problem[0].lower()}{problem[1:]}")
        require_valid_labels(line.groups)

    def require_unique(self, line: RosterLine) -> None:
        """Raise Invalid for a person who stands in the list twice. Numbers or birth dates tell namesakes apart."""
        keys = [f"identifiant « {line.login} »"] if line.login else []
        keys += [f"adresse « {line.email} »"] if line.email else []
        for key in keys:
            earlier = self._seen.setdefault(key, line.line)
            if earlier != line.line:
                raise Invalid(f"même {key} qu’à la ligne {earlier}.")
        if keys:
            return
        namesakes = self._namesakes.setdefault(normalise_name(line.name) or line.name, [])
        same = next((place for key, place in namesakes if not key or not line.key or key == line.key), None)
        if same is not None:
            raise Invalid(
                f"même nom « {line.name} » qu’à la ligne {same} : si ce sont deux personnes, donnez à chacune un "
                "identifiant ou une adresse."
            )
        namesakes.append((line.key, line.line))

    def warnings(self, source: SheetReading) -> tuple[str, ...]:
        warnings = []
        if source.repaired:
            before, after = source.repaired[0]
            warnings.append(REPAIRED.format(before=before, after=after))
        if source.encoding in RARE and not source.other_encodings:
            warnings.append(UNUSUAL.format(used=ENCODING_WORDS[source.encoding]))
        if source.other_encodings:
            used, *others = (ENCODING_WORDS.get(name, name) for name in (source.encoding, *source.other_encodings))
            warnings.append(GUESSED.format(used=used, others=" ou ".join(others)))
        if self._whole:
            lines = ", ".join(map(str, self._whole[:MAX_NAMED_LINES])) + (
                "…" if len(self._whole) > MAX_NAMED_LINES else ""
            )
            text = WHOLE_NAMES if len(self._whole) > 1 else WHOLE_NAME
            warnings.append(text.format(count=len(self._whole), lines=lines))
        return tuple(warnings)


def _name_problem(name: str, is_alone: bool) -> str:
    """Say why a name is none, or return an empty text. `is_alone`: nothing else stands in the line, as in a footer."""
    if not name:
        return "il n’y a ni nom ni prénom."
    if not any(sign.isalpha() for sign in name):
        return f"« {name[:60]} » n’est pas un nom : il n’y a aucune lettre."
    if normalise_name(name) in SUMS or (is_alone and FOOTER.match(_remove_accents(name))):
        return "cette ligne ne paraît pas nommer un élève."
    if len(name) > NAME_LENGTH:
        return f"le nom dépasse {NAME_LENGTH} caractères."
    return "il y a une adresse électronique à la place du nom." if "@" in name else ""


def _tidy_cell(row: SheetRow, index: int) -> str:
    text = normalise_line(row.cells[index]) if index < len(row.cells) else ""
    return "" if text.startswith(FORMULA) else text


def _remove_accents(text: str) -> str:
    return "".join(sign for sign in unicodedata.normalize("NFKD", limit_marks(text)) if not unicodedata.combining(sign))


def _extract_email(text: str) -> str:
    """Return the address of « Ada <ada@example.org> », or the text where there is none, or more than one."""
    folded = unicodedata.normalize("NFKC", limit_marks(text)).casefold().removeprefix("mailto:")
    addresses = set(EMAIL.findall(folded))
    return addresses.pop() if len(addresses) == 1 and re.search(r"[<>\s]", folded) else folded
