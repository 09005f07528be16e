"""What the trial of a declared exercise found, in plain data: what an author reads, and what is stored."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any


@dataclass(frozen=True)
class TriedCase:
    """A written case: what the solution answers, as Python writes it, or why it does not; whether that is expected.

    `raised` is the exception of Python with which the solution ends though its author says no result: a fault of the
    solution, until it is said that this exception is expected. `typed` is what students see in place of `given`, where
    the expected result has other digits.
    """

    check: int
    case: int
    given: str
    agrees: bool
    fault: str = ""
    raised: str = ""
    typed: str = ""


@dataclass(frozen=True)
class TriedMistake:
    """A known mistake: whether it is refused and named, and which mistake is named in its stead.

    `case` is an input that refuses it, or tells it from that other one, where none of the cases does; of which check.
    The solution gives `answer` there; `doubt` says why the statement may exclude that input.
    """

    id: str
    refused: bool
    named: bool
    instead: str = ""
    case: str = ""
    check: int = 0
    answer: str = ""
    doubt: str = ""


@dataclass(frozen=True)
class TriedChange:
    """A change of the solution: the lines before and after, the changed program, and how a case refuses it.

    `case` is an input that shows it though no case does, with `answer` and `doubt` as of `TriedMistake`; `unseen` says
    that none was found, and that it may be no mistake. `operator` is the kind of the change, `words` say it of a whole
    function. `behaviour` is a digest of what it does in the cases, where one refuses it.
    """

    line: int
    before: str
    after: str
    program: str
    refusal: str = ""
    check: int = 0
    case: str = ""
    unseen: bool = False
    answer: str = ""
    doubt: str = ""
    operator: str = ""
    words: str = ""
    behaviour: str = ""

    @property
    def survives(self) -> bool:
        return not self.refusal and not self.unseen


@dataclass(frozen=True)
class TrialReport:
    """A trial. `problem` is what keeps the declaration from being read, at `place`.

    It `is_whole` where everything was tried in time; `is_busy`: the time passed while others had the processor.
    `raising` is a drawn input on which the solution raises an exception of Python, and that exception.
    """

    place: str = ""
    problem: str = ""
    cases: tuple[TriedCase, ...] = ()
    solution: str = ""
    starter: str = ""
    mistakes: tuple[TriedMistake, ...] = ()
    changes: tuple[TriedChange, ...] = ()
    seeds: int = 0
    is_whole: bool = True
    is_busy: bool = False
    raising: tuple[str, str] = ("", "")

    @property
    def proven_survivors(self) -> tuple[TriedChange, ...]:
        """The changes that no check refuses although an input is known on which their answer is wrong."""
        return tuple(change for change in self.changes if change.survives)

    def to_data(self) -> dict[str, Any]:
        return asdict(self)

    @classmethod
    def from_data(cls, data: Mapping[str, Any]) -> TrialReport:
        """Return the report that `to_data` gave."""
        lists = {
            "cases": tuple(TriedCase(**each) for each in data["cases"]),
            "mistakes": tuple(TriedMistake(**each) for each in data["mistakes"]),
            "changes": tuple(TriedChange(**each) for each in data["changes"]),
            "raising": tuple(data.get("raising", ("", ""))),
        }
        return cls(**{**data, **lists})
