"""What the probes of a program recognise."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from enum import Enum
from types import MappingProxyType
from typing import NamedTuple

from graders.core.code.probes import AnswerRule, Experiment, ProbeResults, Probes


class NamingGround(Enum):
    """What a mistake is named on: answers that are those of the mistake, or a resemblance that others share."""

    ANSWERS, RESEMBLANCE = "answers", "resemblance"


class WeakName(NamedTuple):
    """A mistake named on answers that tell little, and the number of the probes; for opinions the text of the mutant
    that answers alike, and the names that rules give `instead`."""

    mistake: str
    number: int
    text: str
    instead: tuple[str, ...]


class RuleName(NamedTuple):
    """A mistake named by a rule, the number of the probes, and the candidates: this mistake and those of the rules that
    come after, each with the experiment of its rule."""

    mistake: str
    number: int
    candidates: tuple[tuple[str, Experiment], ...]


def apply_rules(rules: Sequence[AnswerRule], shown: ProbeResults) -> Sequence[str]:
    """Return the mistake of the first rule that recognises one."""
    return next(([name] for rule in rules if (name := rule(shown)) is not None), [])


def iter_rule_names(probes: Probes, number: int, shown: ProbeResults, names: Sequence[str]) -> Iterator[RuleName]:
    """Yield those of the names that rules give for these answers."""
    given = [(name, rule.experiment) for rule in (*probes.rules, *probes.last_rules) if (name := rule(shown))]
    for k, (name, _) in enumerate(given):
        if name in names and name not in [earlier for earlier, _ in given[:k]]:
            yield RuleName(name, number, tuple(given[k:]))


class RecognisedMistakes(NamedTuple):
    """Ids of the mistakes found, in order; `fallback` ids, from the last rules, for when nothing else finds a name; and
    the functions whose wrong answers are `consequences` of mistakes in others. The mistakes are `certain` where every
    function answers as a mutant with these and no other does; `silent` are named on answers that tell little, of which
    the `likely` ones could not be verified in the program; `ruled` are named by rules. `alike` are the functions that
    answer as with a mistake, by its id."""

    mistakes: tuple[str, ...] = ()
    fallback: tuple[str, ...] = ()
    consequences: tuple[str, ...] = ()
    certain: bool = False
    silent: tuple[WeakName, ...] = ()
    likely: tuple[str, ...] = ()
    ruled: tuple[RuleName, ...] = ()
    alike: Mapping[str, frozenset[str]] = MappingProxyType({})

    @property
    def grounds(self) -> dict[str, NamingGround]:
        """Return what mistakes are named on, by id; none of those that an experiment establishes."""
        return {
            **dict.fromkeys(self.alike, NamingGround.ANSWERS),
            **dict.fromkeys(self.likely, NamingGround.RESEMBLANCE),
        }
