"""What a run is made of: said once by whoever starts it, and handed to each process that plays students."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from random import Random

#: Of the module's first half, as in a lesson: a grading takes 30 to 100 ms. (The slowest challenges take seconds.)
EXERCISES = ("poses", "odometrie", "lidar", "reechantillonnage", "kabsch", "metriques")
MODULE = "l20"
MOST_MISTAKES = 8  # of an exercise, among which wrong attempts are drawn


@dataclass(frozen=True)
class Programs:
    """What is sent to an exercise."""

    right: str
    wrong: Sequence[str]

    def drawn(self, draw: Random, *, right: bool, number: int) -> str:
        """Each differs from all others: what was sent already is not graded again."""
        return f"{self.right if right else draw.choice(self.wrong)}\nessai = {number}\n"


@dataclass(frozen=True)
class Person:
    """What a browser holds from the beginning (nothing, for who has to enter first)."""

    cookie: str = ""
    login: str = ""


@dataclass(frozen=True)
class Plan:
    """One process's part of a run. Times are seconds; `began` is of `time.monotonic`, the machine's."""

    addresses: tuple[str, ...]
    people: Sequence[Person]
    programs: Mapping[str, Programs]
    lessons: Sequence[str]
    think: float
    ramp: float
    seconds: float
    began: float
    seed: int
    password: str = ""
    boards: Sequence[tuple[str, str]] = ()  # cookie of who teaches, address of the class

    def parts(self, count: int) -> Iterator[Plan]:
        """For so many processes; the boards are the first one's."""
        for one in range(count):
            values = {**vars(self), "people": self.people[one::count], "seed": self.seed * 100 + one}
            yield Plan(**{**values, "boards": self.boards if one == 0 else ()})


@dataclass
class Seen:
    """What a process of students has seen: seconds of each kind of request that ended while it was measured, what
    failed, and the processor time that it took itself."""

    times: dict[str, list[float]] = field(default_factory=dict)
    failures: list[str] = field(default_factory=list)
    requests: int = 0
    board_events: int = 0
    processor: float = 0.0

    def add(self, other: Seen) -> None:
        for kind, times in other.times.items():
            self.times.setdefault(kind, []).extend(times)
        self.failures += other.failures
        self.requests += other.requests
        self.board_events += other.board_events
        self.processor += other.processor
