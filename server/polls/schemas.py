"""Questions of the lessons, and counts of a class's answers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from markupsafe import Markup

from graders.scene.prediction import Placed


@dataclass(frozen=True)
class PollOption:
    """`words` in French, with its typography, as HTML that stands in a line."""

    id: str
    words: Markup
    right: bool


@dataclass(frozen=True)
class Poll:
    """A question, named within its module (`rejeux/icp`, `verification/amcl`); `href` leads to it.

    `before`: it is asked before a replay plays, and its first answer alone counts; else it is marked in place, as often
    as one likes. `several`: right answers may be several. `place`: the answer is a place of the drawing, and the
    options are how far it may be.
    """

    name: str
    title: str
    href: str
    question: Markup
    options: tuple[PollOption, ...]
    is_prediction: bool
    several: bool = False
    place: Placed | None = None

    @property
    def right(self) -> str:
        """The right answer, in its stored form."""
        return ",".join(sorted(option.id for option in self.options if option.right))

    def options_counted_for(self, answer: str) -> frozenset[str]:
        """The options that an answer is counted for; none where the question does not, or no longer, take it."""
        if self.place is not None:
            told = self.place.distance_class(answer)
            return frozenset() if told is None else frozenset([told])
        ids = frozenset(answer.split(","))
        known = ids <= {option.id for option in self.options} and answer == ",".join(sorted(ids))
        return ids if known and (self.several or len(ids) == 1) else frozenset()


@dataclass(frozen=True)
class MarkedAnswer:
    """What becomes of an answer: what was said `first`, or nothing where nothing is kept; of a question that is marked
    in place, whether this one is right, and why, as HTML."""

    first: str
    right: bool | None = None
    why: str = ""


class AnswerCount(NamedTuple):
    """So many students of a class answered `first` to a poll, and `last` in the end."""

    poll: str
    first: str
    last: str
    students: int
