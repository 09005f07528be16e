"""The limits of the sandbox, in words: they are data, and a student has a right to know them."""

from __future__ import annotations

from dataclasses import replace

from server.catalogue import Exercise
from server.pages.text import points
from server.sandbox import Policy

MEBIBYTE, KIBIBYTE = 1 << 20, 1 << 10


def limits_of(exercise: Exercise) -> tuple[tuple[str, str], ...]:
    """Name and value of each limit worth knowing, for this exercise."""
    policy = replace(Policy(), **exercise.policy_overrides)
    return (
        ("temps de calcul", f"{points(policy.cpu_seconds)}\u00a0s"),
        ("mémoire", f"{policy.memory_bytes // MEBIBYTE}\u00a0Mo"),
        ("texte affiché", f"{policy.stdout_bytes // KIBIBYTE}\u00a0Ko"),
        ("taille du fichier", f"{policy.source_bytes // KIBIBYTE}\u00a0Ko"),
    )
