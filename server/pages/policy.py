"""The limits of the sandbox, in words: they are data, and a student has a right to know them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from server.course import Exercise
from server.sandbox import Policy
from server.web.words import points

_NO_BREAK, _THIN = "\u00a0", "\u202f"


def _seconds(value: float) -> str:
    return f"{points(value)}{_NO_BREAK}s"


def _size(count: float) -> str:
    for unit, name in ((1 << 30, "Gio"), (1 << 20, "Mio"), (1 << 10, "Kio")):
        if count >= unit:
            return f"{points(count / unit)}{_NO_BREAK}{name}"
    return f"{count:.0f}{_NO_BREAK}octets"


def _count(value: float) -> str:
    """1 500, with the thin space of French thousands."""
    return f"{value:,.0f}".replace(",", _THIN)


def _threads(value: float) -> str:
    return "un seul" if value == 1 else _count(value)


#: One line for each field of the policy, in the order of the page: its name, and how its value reads.
LINES: dict[str, tuple[str, Callable[[float], str]]] = {
    "cpu_seconds": ("Temps de calcul", _seconds),
    "wall_seconds": ("Durée, attentes comprises", _seconds),
    "memory_bytes": ("Mémoire, sans les bibliothèques", _size),
    "source_bytes": ("Taille de votre fichier", _size),
    "stdout_bytes": ("Texte affiché par print", _size),
    "frame_bytes": ("Taille d’une réponse", _size),
    "items": ("Valeurs d’une réponse, hors tableaux", _count),
    "depth": ("Imbrication d’une réponse", lambda value: f"{_count(value)}{_NO_BREAK}niveaux"),
    "threads": ("Fils d’exécution (threads)", _threads),
    "files": ("Fichiers ouverts en même temps", _count),
    "file_bytes": ("Taille d’un fichier écrit", _size),
    "folder_bytes": ("Fichiers écrits, en tout", _size),
}


def limits_of(exercise: Exercise) -> tuple[tuple[str, str], ...]:
    """Name and value of each limit, for this exercise."""
    policy = replace(Policy(), **exercise.policy_overrides)
    return tuple((name, read(getattr(policy, field))) for field, (name, read) in LINES.items())
