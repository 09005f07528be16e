"""Resource limits of one program: one table, enforced by the walls, shown to the student, overridable by an exercise.

A new limit is a new field of `Policy` with its `LimitSpec`: course files, pages and the API read them from there.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields
from typing import Any, Literal

from server.sandbox.child.codec import ValueLimits

KIB, MIB, GIB = 1 << 10, 1 << 20, 1 << 30

Unit = Literal["seconds", "bytes", "count", "levels", "threads"]


@dataclass(frozen=True)
class LimitSpec:
    """Description of a limit: its French label, its unit, and the range in which an exercise may set it."""

    label: str
    unit: Unit
    minimum: float
    maximum: float


def _limit_field(default: Any, words: str, unit: Unit, least: float, most: float) -> Any:
    return field(default=default, metadata={"row": LimitSpec(words, unit, least, most)})


@dataclass(frozen=True)
class Policy:
    """Limits of one session.

    `cpu_seconds` counts the time of the processor over the whole session; `wall_seconds` counts the time spent waiting
    for answers; `memory_bytes` comes above what the interpreter and the libraries use themselves; `threads` counts the
    main one; `files` are descriptors; a program may write files of `file_bytes` each, `folder_bytes` in all, into a
    private folder that goes with it (where the machine cannot give it one, it writes nothing); `depth` and `items`
    bound the nesting and the number of values of an answer, where an array is one value; `session_…` bound all answers
    together. What the trusted side keeps, reads and compares is in proportion to these: they are its limits as well.
    `judging_seconds` is the processor time that it may take itself between a program's first line and its last answer.
    """

    cpu_seconds: float = _limit_field(5.0, "Temps de calcul", "seconds", 0.01, 120)
    wall_seconds: float = _limit_field(12.0, "Durée, attentes comprises", "seconds", 0.01, 300)
    memory_bytes: int = _limit_field(512 * MIB, "Mémoire, sans les bibliothèques", "bytes", 64 * MIB, 4 * GIB)
    source_bytes: int = _limit_field(64 * KIB, "Taille de votre fichier", "bytes", KIB, MIB)
    stdout_bytes: int = _limit_field(64 * KIB, "Texte affiché par print", "bytes", KIB, MIB)
    frame_bytes: int = _limit_field(4 * MIB, "Taille d’une réponse", "bytes", KIB, 64 * MIB)
    items: int = _limit_field(10_000, "Valeurs d’une réponse, hors tableaux", "count", 1000, 1_000_000)
    session_bytes: int = _limit_field(8 * MIB, "Taille des réponses, en tout", "bytes", KIB, 256 * MIB)
    session_items: int = _limit_field(
        100_000, "Valeurs des réponses, en tout, hors tableaux", "count", 1000, 10_000_000
    )
    depth: int = _limit_field(16, "Imbrication d’une réponse", "levels", 4, 60)
    judging_seconds: float = _limit_field(8.0, "Temps pour lire et comparer vos réponses", "seconds", 1, 60)
    threads: int = _limit_field(1, "Fils d’exécution (threads)", "threads", 1, 16)
    files: int = _limit_field(64, "Fichiers ouverts en même temps", "count", 16, 1024)
    file_bytes: int = _limit_field(4 * MIB, "Taille d’un fichier écrit", "bytes", KIB, 64 * MIB)
    folder_bytes: int = _limit_field(16 * MIB, "Fichiers écrits, en tout", "bytes", 64 * KIB, 256 * MIB)

    def __post_init__(self) -> None:
        for name, value in asdict(self).items():
            if value <= 0:
                raise ValueError(f"{name} must be positive, not {value}")

    @property
    def answer_limits(self) -> ValueLimits:
        """Bounds of one encoded answer; a call's value and its arguments are two levels below the top."""
        return ValueLimits(self.frame_bytes, self.depth + 2, self.items)


#: Specification of each field, in the order of the page.
LIMIT_SPECS: Mapping[str, LimitSpec] = {each.name: each.metadata["row"] for each in fields(Policy)}
