"""What the template of a group of programs that answer alike receives."""

from __future__ import annotations

from dataclasses import dataclass

from server.desk.schemas import ClassHead
from server.web.values import ValueView


@dataclass(frozen=True)
class ExampleView:
    """What a program of the group answers to one input. `expected` is None where several answers are right."""

    function: str
    inputs: tuple[tuple[str, ValueView], ...]
    expected: ValueView | None
    got: ValueView
    code: str


@dataclass(frozen=True)
class ProgramRow:
    """An attempt of the group: `href` leads to it, `read_href` has it read here."""

    name: str
    href: str
    read_href: str
    sent: str
    sent_text: str
    points: str
    latest: bool
    shown: bool


@dataclass(frozen=True)
class GroupNameForm:
    """What is written of the name, as it is or as it was sent; `problem` is why that is refused."""

    title: str
    explanation: str
    question: str
    problem: str = ""


@dataclass(frozen=True)
class NameSuggestion:
    """Words that were given to another group of the exercise; `href` puts them into the form."""

    href: str
    title: str


@dataclass(frozen=True)
class GroupPage:
    """Programs that answer alike: `total` by so many `students`, of which `still` have sent nothing since; of `known`
    ones a misconception was named. `named`: they have a name already; `outdated`: the exercise has changed since.

    `questions` are the hints of the checks that the program shown has failed, `titles` the names of the catalogue.
    """

    head: ClassHead
    href: str
    exercise: str
    exercise_href: str
    outdated: bool
    functions: tuple[str, ...]
    students: int
    total: int
    known: int
    still: int
    example: ExampleView | None
    code: str
    code_href: str
    named: bool
    may_name: bool
    earlier: tuple[NameSuggestion, ...]
    questions: tuple[str, ...]
    titles: tuple[str, ...]
    rows: tuple[ProgramRow, ...]
