"""How a submission ends: one table, whose rows are the outcomes themselves.

Pages, command line, API, specimens' folders, marks and precedence take everything from here. A member of the enum is
made with its row: an outcome without words, or that nobody answers for, does not import.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum, StrEnum
from typing import Literal, Self

Kind = Literal["code", "answers"]


class Blame(Enum):
    """The party responsible for an outcome."""

    OURS = "ours"
    STUDENT = "student"
    NOBODY = "nobody"


@dataclass(frozen=True)
class Wording:
    """The text of the page, in French: a title, then one sentence.

    The outcome is that of the worst check, and the first one that failed may have another: the sentence must be true
    beside it, and what is to be mended is said by the checks.
    """

    title: str
    sentence: str


@dataclass(frozen=True)
class OutcomeRow:
    """The properties of an outcome. `brief` is for the command line; `answers` where an exercise answered without code
    has words of its own.
    """

    blame: Blame
    brief: str
    code: Wording
    answers: Wording | None = None


class Outcome(StrEnum):
    """The end of a submission. Of several outcomes, the first in this order names the whole submission."""

    _value_: str
    row: OutcomeRow
    rank: int

    def __new__(cls, name: str, row: OutcomeRow | None = None) -> Self:
        if row is None:  # a default only lets `Outcome("ok")`, the look-up of a member, pass for what it is
            raise TypeError(f"outcome {name} has no row")
        member = str.__new__(cls, name)
        member._value_ = name
        member.row = row
        member.rank = len(cls.__members__)
        return member

    INTERNAL_ERROR = (
        "internal_error",
        OutcomeRow(
            Blame.OURS,
            "erreur de notre côté",
            Wording(
                "Incident de notre côté",
                "La correction n’a pas pu aller à son terme. "
                "Cet essai ne compte pas : vous pouvez le renvoyer tel quel.",
            ),
        ),
    )
    SYNTAX_ERROR = (
        "syntax_error",
        OutcomeRow(
            Blame.STUDENT,
            "erreur de syntaxe",
            Wording("Erreur de syntaxe", "Python n’a pas pu lire votre fichier : rien n’a été exécuté."),
            Wording("Fichier illisible", "Ce fichier de réponses n’a pas pu être lu."),
        ),
    )
    IMPORT_ERROR = (
        "import_error",
        OutcomeRow(
            Blame.STUDENT,
            "import impossible",
            Wording("Importation impossible", "Votre code importe un module qui n’est pas disponible ici."),
        ),
    )
    FORBIDDEN_OPERATION = (
        "forbidden_operation",
        OutcomeRow(
            Blame.STUDENT,
            "opération interdite",
            Wording("Opération interdite", "Votre code a tenté une opération qui n’est pas autorisée ici."),
        ),
    )
    MEMORY_LIMIT = (
        "memory_limit",
        OutcomeRow(
            Blame.STUDENT,
            "mémoire dépassée",
            Wording("Mémoire dépassée", "Votre code demande plus de mémoire qu’il n’en est accordé."),
        ),
    )
    TIMEOUT = (
        "timeout",
        OutcomeRow(
            Blame.STUDENT,
            "temps dépassé",
            Wording(
                "Temps dépassé",
                "Une vérification au moins n’a pas terminé dans le temps accordé : elle dit où en était votre code.",
            ),
        ),
    )
    OUTPUT_LIMIT = (
        "output_limit",
        OutcomeRow(
            Blame.STUDENT,
            "réponse trop volumineuse",
            Wording("Réponse trop volumineuse", "Ce que renvoie votre code est trop gros pour être lu."),
        ),
    )
    MISSING_FUNCTION = (
        "missing_function",
        OutcomeRow(
            Blame.STUDENT,
            "fonction manquante",
            Wording("Fonction manquante", "Une des fonctions demandées n’est pas définie dans votre fichier."),
        ),
    )
    RUNTIME_ERROR = (
        "runtime_error",
        OutcomeRow(
            Blame.STUDENT,
            "erreur à l’exécution",
            Wording(
                "Erreur à l’exécution",
                "Dans une vérification au moins, votre code s’est arrêté sur une exception : elle dit laquelle.",
            ),
        ),
    )
    INVALID_OUTPUT = (
        "invalid_output",
        OutcomeRow(
            Blame.STUDENT,
            "réponse illisible",
            Wording("Résultat illisible", "Une fonction ne renvoie pas ce qui est demandé (type ou forme)."),
            Wording("Réponses incomplètes", "Une réponse au moins manque, ou n’a pas pu être lue."),
        ),
    )
    WRONG_ANSWER = (
        "wrong_answer",
        OutcomeRow(
            Blame.STUDENT,
            "réponse fausse",
            Wording("Réponse à revoir", "Votre code s’exécute, mais certains résultats ne sont pas les bons."),
            Wording("Réponses à revoir", "Chaque question dit ce qui va et ce qui est à reprendre."),
        ),
    )
    OK = (
        "ok",
        OutcomeRow(
            Blame.NOBODY,
            "réussi",
            Wording("Exercice réussi", "Toutes les vérifications passent. Bravo !"),
            Wording(
                "Exercice réussi",
                "Toutes vos réponses sont bonnes. Bravo ! Le corrigé complet est ouvert plus bas.",
            ),
        ),
    )

    @property
    def blame(self) -> Blame:
        return self.row.blame

    @property
    def counts(self) -> bool:
        """Whether the mark counts: what is our own fault never does."""
        return self.blame is not Blame.OURS

    @property
    def brief(self) -> str:
        """In a few French words, as the command line says it."""
        return self.row.brief

    def wording(self, kind: Kind = "code") -> Wording:
        """Return the text of the page for an exercise of this kind."""
        return self.row.answers if kind == "answers" and self.row.answers is not None else self.row.code


def most_telling_outcome(causes: Iterable[Outcome]) -> Outcome:
    """The outcome of a whole whose parts ended so: what is ours wins over everything, OK over nothing.

    Raises ValueError where there is no part: nothing was judged.
    """
    return min(causes, key=lambda cause: cause.rank)


def outcomes_blamed_on(blame: Blame) -> tuple[Outcome, ...]:
    """The outcomes that somebody is answerable for."""
    return tuple(outcome for outcome in Outcome if outcome.blame is blame)


#: Failures that open hints: a file that Python cannot read says nothing of what its author has understood.
OPENS_HINTS = frozenset(outcomes_blamed_on(Blame.STUDENT)) - {Outcome.SYNTAX_ERROR}
