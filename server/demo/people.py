"""The students of the class: names at random, as the names of a year's class are."""

from __future__ import annotations

import unicodedata
from dataclasses import dataclass
from random import Random

GIVEN = (
    "Adèle", "Aminata", "Anaïs", "Antoine", "Baptiste", "Camille", "Clément", "Djibril", "Elif", "Élise", "Enzo",
    "Fatou", "Gabriel", "Hugo", "Inès", "Jade", "Jules", "Karim", "Kenza", "Léa", "Lina", "Louis", "Lucie", "Malo",
    "Manon", "Mathis", "Maxime", "Mehdi", "Nina", "Noé", "Océane", "Paul", "Quentin", "Rayan", "Romane", "Sacha",
    "Salomé", "Samuel", "Théo", "Thomas", "Valentin", "Yasmine", "Yanis", "Zoé",
)  # fmt: skip
FAMILY = (
    "André", "Bailly", "Barbier", "Benali", "Bernard", "Blanc", "Bonnet", "Boucher", "Brunet", "Chevalier", "Cissé",
    "Colin", "Da Silva", "Diallo", "Dubois", "Durand", "Fabre", "Faure", "Fontaine", "Garnier", "Gauthier", "Girard",
    "Guérin", "Haddad", "Henry", "Lambert", "Lefèvre", "Leroy", "Lopez", "Marchand", "Martinez", "Mercier", "Meyer",
    "Moreau", "N’Guyen", "Noël", "Perrin", "Petit", "Renaud", "Rey", "Robin", "Roussel", "Simon", "Vidal", "Yilmaz",
)  # fmt: skip
GROUPS = ("TP1", "TP2")


@dataclass(frozen=True)
class SimulatedStudent:
    """A simulated student; `ease` in [0, 1]: how soon an exercise is understood."""

    given: str
    family: str
    login: str
    group: str
    ease: float
    minutes_between_attempts: float

    @property
    def name(self) -> str:
        return f"{self.given} {self.family}"


def draw_simulated_students(random: Random, count: int) -> tuple[SimulatedStudent, ...]:
    """So many, no two of one login; as many names as there are bound how many."""
    pairs = [(given, family) for given in GIVEN for family in FAMILY]
    chosen = random.sample(pairs, count)
    return tuple(
        SimulatedStudent(
            *(given, family, f"{_ascii_letters(given)}.{_ascii_letters(family)}"),
            group=GROUPS[number * len(GROUPS) // count],
            ease=random.betavariate(4.0, 3.0),
            minutes_between_attempts=random.uniform(1.5, 4.5),
        )
        for number, (given, family) in enumerate(chosen)
    )


def _ascii_letters(name: str) -> str:
    letters = unicodedata.normalize("NFD", name.casefold())
    return "".join(letter for letter in letters if letter.isascii() and letter.isalpha())
