"""What the page of codes that look alike receives."""

from __future__ import annotations

from dataclasses import dataclass

from server.desk.schemas import ClassHead


@dataclass(frozen=True)
class SharedCodeLine:
    """A line of a code: `shared` stands in the other one too."""

    number: int
    text: str
    shared: bool


@dataclass(frozen=True)
class PairSide:
    """One of two codes: whose, where it is, how much of what is their own the other has, in percent."""

    name: str
    href: str
    share: int
    lines: tuple[SharedCodeLine, ...]


@dataclass(frozen=True)
class PairView:
    first: PairSide
    second: PairSide


@dataclass(frozen=True)
class ExerciseChoice:
    id: str
    title: str
    chosen: bool


@dataclass(frozen=True)
class LikenessPage:
    """`compared` codes of the chosen exercise (`chosen`: its title, empty before one is), and those alike."""

    head: ClassHead
    title: str
    href: str
    choices: tuple[ExerciseChoice, ...]
    chosen: str
    compared: int
    too_short: bool
    pairs: tuple[PairView, ...]
