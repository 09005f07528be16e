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


def _words(text: str) -> frozenset[str]:
    return frozenset(text.split())


FILLERS = _words(
    "de du des d la le les l et ou e s es a au aux en pour of the jj mm aaaa obligatoire facultatif required "
    "optional requis requise"
)
#: Whose column it is, when it is no student's.
OTHERS = _words(
    "responsable responsables resp parent parents pere mere tuteur tutrice legal legale legaux representant referent "
    "professeur prof profs enseignant enseignants teacher etablissement ecole lycee college universite institution "
    "voie rue ville commune pays adresse1 adresse2 postal postale cp origine precedent precedente anterieur anterieure "
    "ancien ancienne dernier derniere bourse regime urgence contact conjoint fichier photo department departement"
)
SCHOOLS = _words("etablissement ecole lycee college universite institution")
EMAIL = _words("email emails mail mails courriel courriels mel e-mail messagerie")
OFFICIAL = _words("academique universitaire univ etu ent institutionnel institutionnelle")
LOGIN = _words("identifiant login username user utilisateur uid ent pseudo compte samaccountname userid")
NUMBER = _words(
    "ine bea numero num no n matricule code ref reference dossier idnumber nip number apogee national unique"
)
SECRET_NUMBERS = _words("ine bea national unique nip")  # which students do not know by heart
NUMBER_EXTRA = _words("identification id inscription interne")
KNOWN_NUMBERS = _words("idnumber identification matricule")
KNOWN_TO_STUDENTS = 3  # the rank of a number that students know, as a university's
VAGUE = _words("code ref reference dossier")  # of anything
STUDENT = _words(
    "eleve eleves etudiant etudiante etudiants etudiantes apprenant apprenants apprenante stagiaire stagiaires "
    "candidat candidate candidats candidates student students participant participants participante inscrit inscrits "
    "apprenti apprentis learner pupil membre membres"
)
GIVEN = _words("prenom prenoms firstname forename given givenname")
FAMILY = _words("nom noms lastname surname patronyme familyname sn")
OTHER_GIVEN = _words(
    "deuxieme second seconde troisieme quatrieme cinquieme autre autres suivant suivants 2 3 4 5 2e 3e 2eme 3eme "
    "secondaire secondaires pere mere middle"
)
FIRST = _words("1 premier premiere 1er first principal")
USAGE = _words("usage usuel usuelle prefere preferred courant marital epouse choisi")
BIRTH = _words("naissance patronymique maiden jeune fille birth")
FAMILY_EXTRA = STUDENT | USAGE | BIRTH | _words("famille family last name complet long usage officiel etat civil")
GIVEN_EXTRA = (
    STUDENT | USAGE | _words("premier premiere 1 1er first name principal usage officiel etat civil naissance")
)
CLASS = _words("classe classes division divisions class classroom section")
CLASS_EXTRA = STUDENT | _words("code libelle nom intitule court long actuelle actuel affectation rattachement name")
GROUP = _words(
    "groupe groupes group groups gr grp gp gpe td tp sous demi equipe equipes team cohorte cohort trinome "
    "trinomes binome binomes"
)
PLAIN_GROUP = _words("groupe groupes group groups gr grp gp gpe")
NOT_A_GROUP = _words("type nombre effectif")
DATES = _words("date ne nee naiss birthdate birthday birth naissance dob")
FULL = _words("complet full displayname fullname identite affichage affiche name")


def split_header(text: str) -> tuple[str, ...]:
    """Return the folded words of a header: « Premier prénom* » gives premier, prenom; « lastName » last, name."""
    text = re.sub(r"(?<=[a-zà-ÿ])(?=[A-ZÀ-Þ])", " ", text[:MAX_HEADER])
    text = re.sub(r"\((?:s|e|es|ne)\)", "", text, flags=re.IGNORECASE)  # « Prénom(s) », « Né(e) le »
    text = re.sub(r"[Nn]\s*[°º]", " numero ", text)
    return tuple(re.findall(r"\d+(?:er|e|eme)?(?![a-z])|[^\W\d_]+", normalise_name(text)))


@dataclass(frozen=True)
class _Words:
    """A header as its folded words; `seen` leaves the little ones out."""

    header: str
    words: tuple[str, ...]
    seen: frozenset[str]

    @property
    def joined(self) -> str:
        return " ".join(self.words)

    def read(self, field: RosterField | None, rank: int = 2, qualifier: str = "") -> ColumnReading:
        return ColumnReading(0, self.header, field, rank, qualifier)


@lru_cache(maxsize=2048)
def recognise_header(header: str) -> ColumnReading:
    """Return what a header means, at index 0. Qualifiers decide: « Prénom du père » is nobody's here."""
    words = split_header(header)
    read = _Words(header, words, frozenset(words) - FILLERS)
    if not read.seen or len(words) > MAX_WORDS:
        return read.read(None)
    return next(filter(None, (rule(read) for rule in RULES)), read.read(None))


def _read_others(of: _Words) -> ColumnReading | None:
    """Leave aside what belongs to nobody of the list, but for the addresses that a school gives."""
    is_of_school = _is_email(of) and not of.seen & OTHERS - SCHOOLS
    return of.read(None) if of.seen & OTHERS and not is_of_school else None


def _is_email(of: _Words) -> bool:
    return bool(of.seen & EMAIL) or "adresse electronique" in of.joined


def _read_email(of: _Words) -> ColumnReading | None:
    if not _is_email(of):
        return None
    return of.read(RosterField.email, 1 if "perso" in of.joined else 3 if of.seen & (OFFICIAL | SCHOOLS) else 2)


def _read_both_names(of: _Words) -> ColumnReading | None:
    both = (of.seen & GIVEN and of.seen & FAMILY) or {"first", "last"} <= of.seen
    if not both or of.seen - GIVEN - FAMILY - GIVEN_EXTRA - FAMILY_EXTRA:
        return None
    first = next(word for word in of.words if word in GIVEN | FAMILY | {"first", "last"})
    return of.read(RosterField.reversed_name if first in GIVEN | {"first"} else RosterField.full_name)


def _read_given(of: _Words) -> ColumnReading | None:
    if not (of.seen & GIVEN or {"first", "name"} <= of.seen):
        return None
    if of.seen & (OTHER_GIVEN | LOGIN) or of.seen - GIVEN - GIVEN_EXTRA:
        return of.read(None)
    rank = 4 if of.seen & USAGE else 3 if of.seen & FIRST else 1 if "prenoms" in of.seen else 2
    return of.read(RosterField.given, rank)


def _read_group(of: _Words) -> ColumnReading | None:
    is_group = of.seen & GROUP and not of.seen & NOT_A_GROUP and (of.seen & PLAIN_GROUP or len(of.seen) <= 2)
    return of.read(RosterField.group, 2, _qualifier(of.header, of.words)) if is_group else None


def _read_class(of: _Words) -> ColumnReading | None:
    if not of.seen & CLASS or of.seen - CLASS - CLASS_EXTRA:
        return None
    return of.read(RosterField.school_class, 1 if of.seen & {"libelle", "long"} else 3 if "code" in of.seen else 2)


def _read_complete_name(of: _Words) -> ColumnReading | None:
    is_name = of.seen & FAMILY and of.seen & {"complet", "full"} and not of.seen - FAMILY - FAMILY_EXTRA - LOGIN - FULL
    return of.read(RosterField.complete_name) if is_name else None


def _read_login(of: _Words) -> ColumnReading | None:
    if not (of.seen & LOGIN or of.seen == {"id"} or of.joined in {"user name", "id utilisateur", "id ent"}):
        return None
    if of.seen & {"unique", "national", "numero"}:
        return of.read(RosterField.number)
    return of.read(RosterField.login, 3 if "ent" in of.seen else 2)


def _read_birth(of: _Words) -> ColumnReading | None:
    if "lieu" in of.seen:
        return of.read(None)
    is_birth = of.seen & DATES and not of.seen & FAMILY and not of.seen - DATES - STUDENT - BIRTH
    return of.read(RosterField.birth) if is_birth else None


def _read_family(of: _Words) -> ColumnReading | None:
    if not (of.seen & FAMILY or {"last", "name"} <= of.seen or {"family", "name"} <= of.seen):
        return None
    if of.seen - FAMILY - FAMILY_EXTRA:
        return of.read(None)
    return of.read(RosterField.family, 3 if of.seen & USAGE else 1 if of.seen & BIRTH else 2)


def _read_number(of: _Words) -> ColumnReading | None:
    if of.seen == {"id", "number"}:
        return of.read(RosterField.number, KNOWN_TO_STUDENTS)
    if not of.seen & NUMBER or of.seen <= VAGUE or of.seen - NUMBER - STUDENT - NUMBER_EXTRA:
        return None
    is_known = of.seen & (STUDENT | KNOWN_NUMBERS) and not of.seen & SECRET_NUMBERS
    return of.read(RosterField.number, KNOWN_TO_STUDENTS if is_known else 1 if of.seen == {"numero"} else 2)


def _read_student(of: _Words) -> ColumnReading | None:
    return of.read(RosterField.complete_name) if not of.seen - STUDENT - FULL else None


#: The first rule that decides is right.
RULES = (
    _read_others, _read_email, _read_both_names, _read_given, _read_group, _read_class, _read_complete_name,
    _read_login, _read_birth, _read_family, _read_number, _read_student,
)  # fmt: skip


def _qualifier(header: str, words: Sequence[str]) -> str:
    """Return the words that tell a column of groups from another one: « Groupe TD » gives TD."""
    plain = PLAIN_GROUP | FILLERS | _words("nom libelle code numero")
    kept = [word for word in re.findall(r"\w+", header) if not set(split_header(word)) <= plain]
    return " ".join(kept) if len(words) > 1 or words[0] in {"td", "tp"} else ""
