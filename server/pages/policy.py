"""What a program may use, in words: the policy is data, and a student has a right to know it."""

from __future__ import annotations

from collections.abc import Callable

from server.base.sizes import NO_BREAK, size
from server.course import Exercise
from server.web.words import points

_THIN = "\u202f"


def _seconds(value: float) -> str:
    return f"{points(value)}{NO_BREAK}s"


def _count(value: float) -> str:
    """1 500, with the thin space of French thousands."""
    return f"{value:,.0f}".replace(",", _THIN)


def _threads(value: float) -> str:
    return "un seul" if value == 1 else _count(value)


#: One line for each field of the policy, in the order of the page: its name, and how its value reads.
LINES: dict[str, tuple[str, Callable[[float], str]]] = {
    "cpu_seconds": ("Temps de calcul", _seconds),
    "wall_seconds": ("Durée, attentes comprises", _seconds),
    "memory_bytes": ("Mémoire, sans les bibliothèques", size),
    "source_bytes": ("Taille de votre fichier", size),
    "stdout_bytes": ("Texte affiché par print", size),
    "frame_bytes": ("Taille d’une réponse", size),
    "items": ("Valeurs d’une réponse, hors tableaux", _count),
    "depth": ("Imbrication d’une réponse", lambda value: f"{_count(value)}{NO_BREAK}niveaux"),
    "threads": ("Fils d’exécution (threads)", _threads),
    "files": ("Fichiers ouverts en même temps", _count),
    "file_bytes": ("Taille d’un fichier écrit", size),
    "folder_bytes": ("Fichiers écrits, en tout", size),
}


def policy_lines(exercise: Exercise) -> tuple[tuple[str, str], ...]:
    """Name and value of each line of the policy, for this exercise."""
    return tuple((name, read(getattr(exercise.policy, field))) for field, (name, read) in LINES.items())
