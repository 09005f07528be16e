"""Recognise a header of a school's list by its meaning, read word by word.

Every school program has its words, and exports change: accents, case, punctuation and numbers do not count, and
qualifiers decide.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from functools import lru_cache

from server.classes.folding import normalise_name

MAX_HEADER, MAX_WORDS = 120, 10  # of a header: more are a sentence


class RosterField(StrEnum):
    """A column that is read. The first five are those of the contract."""

    family = "nom"
    given = "prenom"
    email = "email"
    login = "identifiant"
    group = "groupe"
    full_name = "nom_prenom"
    reversed_name = "prenom_nom"
    complete_name = "nom_complet"
    number = "numero"
    birth = "naissance"
    school_class = "classe"


#: The words of each column for teachers.
FIELD_WORDS = {
    RosterField.family: "Nom de famille", RosterField.given: "Prénom", RosterField.full_name: "Nom puis prénom",
    RosterField.reversed_name: "Prénom puis nom", RosterField.complete_name: "Nom complet, coupé aux capitales",
    RosterField.email: "Adresse électronique", RosterField.login: "Identifiant", RosterField.group: "Groupe",
    RosterField.school_class: "Classe, division", RosterField.number: "Numéro d’élève",
    RosterField.birth: "Date de naissance",
}  # fmt: skip
FULL_NAMES = frozenset({RosterField.full_name, RosterField.reversed_name, RosterField.complete_name})
NAMES = FULL_NAMES | {RosterField.family, RosterField.given}
#: Several columns of these are read together; of the others the best one.
PLURAL = frozenset({RosterField.group})


@dataclass(frozen=True)
class ColumnReading:
    """How one column is read: `field` None is left aside. Among columns of a field the highest `rank` that is filled
    counts; `qualifier` tells columns of groups apart."""

    index: int
    header: str
    field: RosterField | None = None
    rank: int = 0
    qualifier: str = ""


def _word_set(text: str) -> frozenset[str]:
    return frozenset(text.split())


FILLERS = _word_set(
    "de du des d la le les l et ou e s es a au aux en pour of the jj mm aaaa obligatoire facultatif required "
    "optional requis requise"
)
#: Whose column it is, when it is no student's.
OTHERS = _word_set(
    "responsable responsables resp parent parents pere mere tuteur tutrice legal legale legaux representant referent "
    "professeur prof profs enseignant enseignants teacher etablissement ecole lycee college universite institution "
    "voie rue ville commune pays adresse1 adresse2 postal postale cp origine precedent precedente anterieur anterieure "
    "ancien ancienne dernier derniere bourse regime urgence contact conjoint fichier photo department departement"
)
SCHOOLS = _word_set("etablissement ecole lycee college universite institution")
EMAIL = _word_set("email emails mail mails courriel courriels mel e-mail messagerie")
OFFICIAL = _word_set("academique universitaire univ etu ent institutionnel institutionnelle")
LOGIN = _word_set("identifiant login username user utilisateur uid ent pseudo compte samaccountname userid")
NUMBER = _word_set(
    "ine bea numero num no n matricule code ref reference dossier idnumber nip number apogee national unique"
)
SECRET_NUMBERS = _word_set("ine bea national unique nip")  # which students do not know by heart
NUMBER_EXTRA = _word_set("identification id inscription interne")
KNOWN_NUMBERS = _word_set("idnumber identification matricule")
KNOWN_TO_STUDENTS = 3  # the rank of a number that students know, as a university's
VAGUE = _word_set("code ref reference dossier")  # of anything
STUDENT = _word_set(
    "eleve eleves etudiant etudiante etudiants etudiantes apprenant apprenants apprenante stagiaire stagiaires "
    "candidat candidate candidats candidates student students participant participants participante inscrit inscrits "
    "apprenti apprentis learner pupil membre membres"
)
GIVEN = _word_set("prenom prenoms firstname forename given givenname")
FAMILY = _word_set("nom noms lastname surname patronyme familyname sn")
OTHER_GIVEN = _word_set(
    "deuxieme second seconde troisieme quatrieme cinquieme autre autres suivant suivants 2 3 4 5 2e 3e 2eme 3eme "
    "secondaire secondaires pere mere middle"
)
FIRST = _word_set("1 premier premiere 1er first principal")
USAGE = _word_set("usage usuel usuelle prefere preferred courant marital epouse choisi")
BIRTH = _word_set("naissance patronymique maiden jeune fille birth")
FAMILY_EXTRA = STUDENT | USAGE | BIRTH | _word_set("famille family last name complet long usage officiel etat civil")
GIVEN_EXTRA = (
    STUDENT | USAGE | _word_set("premier premiere 1 1er first name principal usage officiel etat civil naissance")
)
CLASS = _word_set("classe classes division divisions class classroom section")
CLASS_EXTRA = STUDENT | _word_set("code libelle nom intitule court long actuelle actuel affectation rattachement name")
GROUP = _word_set(
    "groupe groupes group groups gr grp gp gpe td tp sous demi equipe equipes team cohorte cohort trinome "
    "trinomes binome binomes"
)
PLAIN_GROUP = _word_set("groupe groupes group groups gr grp gp gpe")
NOT_A_GROUP = _word_set("type nombre effectif")
DATES = _word_set("date ne nee naiss birthdate birthday birth naissance dob")
FULL = _word_set("complet full displayname fullname identite affichage affiche name")


def split_header(text: str) -> tuple[str, ...]:
    """Return the folded words of a header: « Premier prénom* » gives premier, prenom; « lastName » last, name."""
    text = re.sub(r"(?<=[a-zà-ÿ])(?=[A-ZÀ-Þ])", " ", text[:MAX_HEADER])
    text = re.sub(r"\((?:s|e|es|ne)\)", "", text, flags=re.IGNORECASE)  # « Prénom(s) », « Né(e) le »
    text = re.sub(r"[Nn]\s*[°º]", " numero ", text)
    return tuple(re.findall(r"\d+(?:er|e|eme)?(?![a-z])|[^\W\d_]+", normalise_name(text)))


@dataclass(frozen=True)
class _HeaderWords:
    """A header as its folded words; `seen` leaves the little ones out."""

    header: str
    words: tuple[str, ...]
    seen: frozenset[str]

    @property
    def joined_text(self) -> str:
        return " ".join(self.words)

    def make_reading(self, field: RosterField | None, rank: int = 2, qualifier: str = "") -> ColumnReading:
        return ColumnReading(0, self.header, field, rank, qualifier)


@lru_cache(maxsize=2048)
def recognise_header(header: str) -> ColumnReading:
    """Return what a header means, at index 0. Qualifiers decide: « Prénom du père » is nobody's here."""
    words = split_header(header)
    read = _HeaderWords(header, words, frozenset(words) - FILLERS)
    if not read.seen or len(words) > MAX_WORDS:
        return read.make_reading(None)
    return next(filter(None, (rule(read) for rule in RULES)), read.make_reading(None))


def _read_unrelated_column(words: _HeaderWords) -> ColumnReading | None:
    """Leave aside what belongs to nobody of the list, but for the addresses that a school gives."""
    is_of_school = _mentions_email(words) and not words.seen & OTHERS - SCHOOLS
    return words.make_reading(None) if words.seen & OTHERS and not is_of_school else None


def _mentions_email(words: _HeaderWords) -> bool:
    return bool(words.seen & EMAIL) or "adresse electronique" in words.joined_text


def _read_email_column(words: _HeaderWords) -> ColumnReading | None:
    if not _mentions_email(words):
        return None
    return words.make_reading(
        RosterField.email, 1 if "perso" in words.joined_text else 3 if words.seen & (OFFICIAL | SCHOOLS) else 2
    )


def _read_full_name_column(words: _HeaderWords) -> ColumnReading | None:
    both = (words.seen & GIVEN and words.seen & FAMILY) or {"first", "last"} <= words.seen
    if not both or words.seen - GIVEN - FAMILY - GIVEN_EXTRA - FAMILY_EXTRA:
        return None
    first = next(word for word in words.words if word in GIVEN | FAMILY | {"first", "last"})
    return words.make_reading(RosterField.reversed_name if first in GIVEN | {"first"} else RosterField.full_name)


def _read_given_name_column(words: _HeaderWords) -> ColumnReading | None:
    if not (words.seen & GIVEN or {"first", "name"} <= words.seen):
        return None
    if words.seen & (OTHER_GIVEN | LOGIN) or words.seen - GIVEN - GIVEN_EXTRA:
        return words.make_reading(None)
    rank = 4 if words.seen & USAGE else 3 if words.seen & FIRST else 1 if "prenoms" in words.seen else 2
    return words.make_reading(RosterField.given, rank)


def _read_group_column(words: _HeaderWords) -> ColumnReading | None:
    is_group = (
        words.seen & GROUP and not words.seen & NOT_A_GROUP and (words.seen & PLAIN_GROUP or len(words.seen) <= 2)
    )
    return words.make_reading(RosterField.group, 2, _group_qualifier(words.header, words.words)) if is_group else None


def _read_class_column(words: _HeaderWords) -> ColumnReading | None:
    if not words.seen & CLASS or words.seen - CLASS - CLASS_EXTRA:
        return None
    return words.make_reading(
        RosterField.school_class, 1 if words.seen & {"libelle", "long"} else 3 if "code" in words.seen else 2
    )


def _read_bare_name_column(words: _HeaderWords) -> ColumnReading | None:
    is_name = (
        words.seen & FAMILY
        and words.seen & {"complet", "full"}
        and not words.seen - FAMILY - FAMILY_EXTRA - LOGIN - FULL
    )
    return words.make_reading(RosterField.complete_name) if is_name else None


def _read_login_column(words: _HeaderWords) -> ColumnReading | None:
    if not (
        words.seen & LOGIN or words.seen == {"id"} or words.joined_text in {"user name", "id utilisateur", "id ent"}
    ):
        return None
    if words.seen & {"unique", "national", "numero"}:
        return words.make_reading(RosterField.number)
    return words.make_reading(RosterField.login, 3 if "ent" in words.seen else 2)


def _read_birth_column(words: _HeaderWords) -> ColumnReading | None:
    if "lieu" in words.seen:
        return words.make_reading(None)
    is_birth = words.seen & DATES and not words.seen & FAMILY and not words.seen - DATES - STUDENT - BIRTH
    return words.make_reading(RosterField.birth) if is_birth else None


def _read_family_name_column(words: _HeaderWords) -> ColumnReading | None:
    if not (words.seen & FAMILY or {"last", "name"} <= words.seen or {"family", "name"} <= words.seen):
        return None
    if words.seen - FAMILY - FAMILY_EXTRA:
        return words.make_reading(None)
    return words.make_reading(RosterField.family, 3 if words.seen & USAGE else 1 if words.seen & BIRTH else 2)


def _read_number_column(words: _HeaderWords) -> ColumnReading | None:
    if words.seen == {"id", "number"}:
        return words.make_reading(RosterField.number, KNOWN_TO_STUDENTS)
    if not words.seen & NUMBER or words.seen <= VAGUE or words.seen - NUMBER - STUDENT - NUMBER_EXTRA:
        return None
    is_known = words.seen & (STUDENT | KNOWN_NUMBERS) and not words.seen & SECRET_NUMBERS
    return words.make_reading(
        RosterField.number, KNOWN_TO_STUDENTS if is_known else 1 if words.seen == {"numero"} else 2
    )


def _read_student_column(words: _HeaderWords) -> ColumnReading | None:
    return words.make_reading(RosterField.complete_name) if not words.seen - STUDENT - FULL else None


#: The first rule that decides is right.
RULES = (
    _read_unrelated_column, _read_email_column, _read_full_name_column, _read_given_name_column, _read_group_column,
    _read_class_column, _read_bare_name_column, _read_login_column, _read_birth_column, _read_family_name_column,
    _read_number_column, _read_student_column,
)  # fmt: skip


def _group_qualifier(header: str, words: Sequence[str]) -> str:
    """Return the words that tell a column of groups from another one: « Groupe TD » gives TD."""
    plain = PLAIN_GROUP | FILLERS | _word_set("nom libelle code numero")
    kept = [word for word in re.findall(r"\w+", header) if not set(split_header(word)) <= plain]
    return " ".join(kept) if len(words) > 1 or words[0] in {"td", "tp"} else ""
