"""Probes: small inputs made by hand, whose answers tell one mistake apart from the others.

They are asked only once some check has failed, and are the same whatever the seed: so is the name. The answers are
compared with those of the exercise's mutants (`mutations`), first with one mistake, then with two together, then three.
A name is given with full confidence or not at all: every probe must be answered as the mutant answers it, at least one
of them wrongly, and where mutants of several mistakes agree, only the mistakes that all of them make are named.
What no mutant reproduces is left to `rules`, which know a mistake by what several answers have in common.
"""

from __future__ import annotations

import itertools
import threading
import time
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any, NamedTuple

from graders.core.code.answer_arrays import AnswerSequence
from graders.core.code.mutants import MAX_COMBINED_MISTAKES, MutantAnswerCache, MutantRow
from graders.core.code.mutations import Model, Mutant
from graders.core.code.piggyback import HANG_SECONDS
from graders.core.code.probes import ProbeAnswer, ProbeFault, ProbeResults, Probes, Rule, read_answer, same_probe_answer
from graders.core.code.runner import Runner
from graders.core.code.stateless import is_stateless
from graders.core.compare.slips import SLIPS
from graders.core.contract.local import kit_names
from graders.core.contract.program import KitSettings, PlannedCalls, StudentFault, flatten_blocks
from graders.core.contract.rows import as_rows

#: The slips of a function that answers the same input otherwise the second time: by what it keeps, or by chance.
MEMORY, CHANCE = "memoire", "hasard"
OTHER_SEED = 1
#: Seconds that all the probes may take a program: one that is slower is not named by them.
MAX_PROBING_SECONDS = HANG_SECONDS


class RecognisedMistakes(NamedTuple):
    """The ids of the mistakes found, the first one first; those of the last rules, for when nothing else finds a name;
    and the functions whose wrong answers follow from mistakes found in others."""

    mistakes: tuple[str, ...] = ()
    fallback: tuple[str, ...] = ()
    consequences: tuple[str, ...] = ()


class Prober:
    """Recognises mistakes by probes; keeps what the mutants answer, which never changes.

    `whole` are programs that make one mistake in another way than by an edit of the model.
    """

    def __init__(self, model: Model, probes: Sequence[Probes], whole: Sequence[Mutant] = ()) -> None:
        self.model = model
        self.probes = tuple(probes)
        self._mutants = MutantAnswerCache(model, self.probes, whole)
        self._lock = threading.Lock()
        self._foreseen = [PlannedCalls(one.function, as_rows((*one.calls, one.calls[0]))) for one in self.probes]

    def is_stateless(self, source: bytes, kit: KitSettings) -> bool:
        """Whether a program that is launched with this kit answers probes whenever it is asked them as one launched
        afresh with theirs would."""
        same = all((one.kit.module, one.kit.without) == (kit.module, kit.without) for one in self.probes)
        return same and is_stateless(source, self._given)

    @cached_property
    def _given(self) -> Mapping[str, Any]:
        """The names that programs find when they are asked the probes."""
        kits = {id(one.kit): one.kit for one in self.probes}
        return {name: value for kit in kits.values() for name, value in kit_names(kit).items()}

    def planned_calls(self, functions: Collection[str], alone: Collection[str]) -> Sequence[PlannedCalls]:
        """All that `recognise` asks a program that it does not see to remember or to draw."""
        return [self._foreseen[index] for index, _ in self._chosen(functions, alone)]

    @property
    def functions(self) -> frozenset[str]:
        return frozenset(probes.function for probes in self.probes)

    def recognise(self, runner: Runner, functions: Collection[str], alone: Collection[str]) -> RecognisedMistakes:
        """The mistakes that the program makes in these functions; none when unsure.

        `alone` are the functions that failed a check of their own.
        """
        found: list[str] = []
        last: list[str] = []
        follow: list[str] = []
        for index, answers, unlike in self._asked(runner, functions, alone):
            if unlike is not None:
                found += [one for one in (unlike,) if one not in found]
                continue
            with self._lock:
                packed = AnswerSequence(answers)
                if found and self._follows(index, packed, found):
                    follow.append(self.probes[index].function)
                    last += self._last(index, packed)
                    continue
                names = self._explained(index, packed, functions)
                found += [one for one in names if one not in found]
                if not names:
                    last += self._last(index, packed)
        return RecognisedMistakes(tuple(found), tuple(last), tuple(follow))

    def _follows(self, index: int, packed: AnswerSequence, found: Sequence[str]) -> bool:
        """Are the mistakes found in other functions all that there is to wrong answers of this one?"""
        if self._right(index, packed) is None:
            return False
        return any(self._mutants.matches(index, row, packed) for row in self._mutants.mutants_making(index, found))

    def nearest_right_answers(self, index: int, answers: Sequence[ProbeAnswer]) -> Sequence[ProbeAnswer]:
        """What is right, in the style that is nearest to these answers to the probes of that number."""
        with self._lock:
            right = self._right(index, AnswerSequence(answers))
        return answers if right is None else right

    def _last(self, index: int, packed: AnswerSequence) -> Sequence[str]:
        probes = self.probes[index]
        right = self._right(index, packed)
        if right is None:
            return ()
        return _ruled(probes.last_rules, ProbeResults(probes.calls, packed.answers, right, probes.same))

    def _asked(
        self, runner: Runner, functions: Collection[str], alone: Collection[str]
    ) -> Iterator[tuple[int, list[ProbeAnswer], str | None]]:
        """What a program launched afresh, which remembers nothing of the checks, answers to the probes of functions.

        Beside the answers, MEMORY or CHANCE when the first call made once more is not answered as the first time. The
        program is then launched once more, with another seed, and asked all that it was asked: what it keeps of the
        probes before is then the same, what it draws is not.
        """
        deadline = time.monotonic() + MAX_PROBING_SECONDS
        chosen = self._chosen(functions, alone)
        for _, group in itertools.groupby(chosen, key=lambda pair: id(pair[1].kit)):
            indices, asked = zip(*group, strict=True)
            ahead = [self._foreseen[index] for index in indices]
            told = _told_beside(runner, asked, ahead) or _told(runner, asked, ahead, asked[0].kit, deadline)
            unlike = [_differs(probes, answers) for probes, answers in zip(asked, told, strict=False)]
            retold: Sequence[list[ProbeAnswer]] = ()
            if any(unlike):
                retold = _told(runner, asked, ahead, _reseeded(asked[0].kit), time.monotonic() + MAX_PROBING_SECONDS)
            for k, answers in enumerate(told):
                if len(answers) > len(asked[k].calls):
                    again = retold[k] if retold and unlike[k] else ()
                    yield indices[k], answers[:-1], _reason(answers, again)

    def _chosen(self, functions: Collection[str], alone: Collection[str]) -> Sequence[tuple[int, Probes]]:
        return [
            (index, probes)
            for index, probes in enumerate(self.probes)
            if probes.function in functions and not probes.unless.intersection(alone)
        ]

    def _explained(self, index: int, packed: AnswerSequence, blamed: Collection[str]) -> Sequence[str]:
        probes, answers = self.probes[index], packed.answers
        right = self._right(index, packed)
        if right is None:
            return ()
        shown = ProbeResults(probes.calls, answers, right, probes.same)
        told = [k for k in shown.wrong_indices() if probes.compared is None or k < probes.compared]
        fails = all(isinstance(answer, ProbeFault | str | None) for answer in answers)
        for mistakes, rows in enumerate(self._candidates(index, answers) if told else (), 1):
            if fails and mistakes > 1:
                break  # exceptions and no value alone tell too little: some pair of mistakes always gives the same ones
            fits = [row for row in rows if row.mutant.applies_to(blamed) and self._mutants.matches(index, row, packed)]
            if fits:
                return _agreed(fits) or _ruled(probes.rules, shown)
        return _ruled(probes.rules, shown)

    def _candidates(self, index: int, answers: Sequence[ProbeAnswer]) -> Iterator[Iterable[MutantRow]]:
        """What may explain the answers, the fewest mistakes first; what costs more is made when nothing else does."""
        for mistakes in range(1, MAX_COMBINED_MISTAKES + 1):
            yield self._mutants.matching_first_answer(index, mistakes, answers[0])
        yield self._mutants.extended_mutants(index, answers)

    def _right(self, index: int, packed: AnswerSequence) -> Sequence[ProbeAnswer] | None:
        """What is right, in the nearest style; None when the answers are."""
        rows = self._mutants.mutants_with(index, 0)
        agreeing = [self._mutants.count_agreements(index, row, packed) for row in rows]
        best = agreeing.index(max(agreeing))
        return None if agreeing[best] == len(packed.answers) else rows[best].told.answers


def _ruled(rules: Sequence[Rule], shown: ProbeResults) -> Sequence[str]:
    """What the first rule that knows says."""
    return next(([name] for rule in rules if (name := rule(shown)) is not None), [])


def _agreed(fits: Sequence[MutantRow]) -> Sequence[str]:
    """The mistakes that all of these make; a usual slip says less than a mistake of the exercise."""
    fits = [row for row in fits if not SLIPS.keys() & set(row.mutant.ids)] or fits
    common = set(fits[0].mutant.ids).intersection(*(row.mutant.ids for row in fits[1:]))
    return [one for one in fits[0].mutant.ids if one in common]


def _told_beside(runner: Runner, asked: Sequence[Probes], ahead: Sequence[PlannedCalls]) -> list[list[ProbeAnswer]]:
    """What a program that remembers nothing has answered beside what else it was asked; nothing where it was not, or
    where it seems to remember."""
    given = [runner.piggybacked_answers(one) if runner.is_callable(one.function) else () for one in ahead]
    if any(answers is None for answers in given):
        return []
    told = [
        [read_answer(args, answer, probes.read) for args, answer in zip(one.calls, answers or (), strict=False)]
        for probes, one, answers in zip(asked, ahead, given, strict=True)
    ]
    return [] if any(map(_differs, asked, told)) else told


def _told(
    runner: Runner, probed: Sequence[Probes], foreseen: Sequence[PlannedCalls], kit: KitSettings, deadline: float
) -> list[list[ProbeAnswer]]:
    """What one launch of the student's program answers to all these probes in turn; nothing when it does not start.

    They go with its file. The answers are cut short by a fault that stops it, or when it takes too long.
    """
    told: list[list[ProbeAnswer]] = [[] for _ in probed]
    still = [place for place, one in enumerate(foreseen) if runner.is_callable(one.function)]
    ahead = [foreseen[place] for place in still]
    try:
        with runner.side_program(kit, ahead) as program:
            for number, answer in flatten_blocks(program.call_batches(ahead)):
                place, function = still[number], ahead[number].function
                runner.note(program, function, answer)
                if time.monotonic() > deadline or (isinstance(answer, StudentFault) and answer.fatal):
                    break
                args = ahead[number].calls[len(told[place])]
                told[place].append(read_answer(args, answer, probed[place].read))
    except StudentFault:
        return []
    return told


def _reseeded(kit: KitSettings) -> KitSettings:
    return replace(kit, parameters={**kit.parameters, "seed": OTHER_SEED})


def _differs(probes: Probes, answers: Sequence[ProbeAnswer]) -> bool:
    """Is the first call, made once more after the others, answered otherwise?"""
    return not probes.random and len(answers) > len(probes.calls) and not same_probe_answer(answers[-1], answers[0])


def _reason(answers: Sequence[ProbeAnswer], again: Sequence[ProbeAnswer]) -> str | None:
    """Why the same call was answered otherwise, from what another launch answers; None when that does not tell."""
    if len(again) < len(answers):
        return None
    return MEMORY if all(same_probe_answer(one, other) for one, other in zip(answers, again, strict=True)) else CHANCE
