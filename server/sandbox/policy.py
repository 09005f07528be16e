"""What one program may use, as data: enforced by the walls, shown to the student, overridable for an exercise."""

from __future__ import annotations

from dataclasses import asdict, dataclass

from server.sandbox.child.codec import Limits

KIB, MIB = 1 << 10, 1 << 20


@dataclass(frozen=True)
class Policy:
    """Limits of one session.

    `cpu_seconds` counts the time of the processor over the whole session; `wall_seconds` counts the time spent waiting
    for answers; `memory_bytes` comes above what the interpreter and the libraries use themselves; `threads` counts the
    main one; `files` are descriptors; a program may write files of `file_bytes` each, `folder_bytes` in all, into a
    private folder that goes with it (where the machine cannot give it one, it writes nothing); `depth` and `items`
    bound the nesting and the number of values of an answer.
    """

    cpu_seconds: float = 5.0
    wall_seconds: float = 12.0
    memory_bytes: int = 512 * MIB
    stdout_bytes: int = 64 * KIB
    frame_bytes: int = 8 * MIB
    source_bytes: int = 64 * KIB
    threads: int = 1
    files: int = 64
    file_bytes: int = 4 * MIB
    folder_bytes: int = 16 * MIB
    depth: int = 16
    items: int = 200_000

    def __post_init__(self) -> None:
        for name, value in asdict(self).items():
            if value <= 0:
                raise ValueError(f"{name} must be positive, not {value}")

    @property
    def answer(self) -> Limits:
        """Bounds of one encoded answer: a call's value and its arguments are two levels below the top."""
        return Limits(self.frame_bytes, self.depth + 2, self.items)
