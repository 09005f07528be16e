"""A name on answers that tell little is held against the program itself: the mistake is undone there, and it is run.

A function that fails everywhere, or returns zeros only, answers as several mistakes of the catalogue make it answer.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Collection

from graders.core.code.changes import count_turns
from graders.core.code.prober import Prober
from graders.core.code.probes import ProbeFault, Probes
from graders.core.code.recognised import RecognisedMistakes
from graders.core.code.repairs import find_repairs
from graders.core.code.runner import Runner
from graders.core.code.variants import VariantCaller

#: Places at which a mistake is undone, and probes asked of the program then.
MAX_UNDONE, MAX_ASKED = 40, 6


def verify_silent(
    found: RecognisedMistakes, prober: Prober | None, runner: Runner, holds: Callable[[Probes, str], bool]
) -> RecognisedMistakes:
    """Return what was found, the mistakes named on answers that tell little held against the program.

    Of opinions, those stay on which the checks judge the mutant as they judged the program (`holds`); rules name the
    others, where they do. What mends nothing where it is undone is `likely` only.
    """
    if prober is None:
        return found
    edits = {edit.id: edit.functions for edit in prober.model.edits}
    instead: dict[str, tuple[str, ...]] = {}
    likely = []
    for silent in found.silent:
        name, probes = silent.mistake, prober.probes[silent.number]
        if silent.text and holds(probes, silent.text):
            continue
        if silent.instead:
            instead[name] = silent.instead
        elif not _mends(name, edits[name], silent.number, prober, runner):
            likely.append(name)
    if not instead and not likely:
        return found
    names = [instead.get(name, (name,)) for name in found.mistakes]
    mistakes = tuple(dict.fromkeys(name for several in names for name in several))
    return found._replace(mistakes=mistakes, certain=False, likely=tuple(likely))


def _mends(name: str, functions: Collection[str], index: int, prober: Prober, runner: Runner) -> bool:
    """Whether some answer becomes right in the program with the mistake undone at some place."""
    source, probes = runner.source.decode("utf-8-sig", "replace"), prober.probes[index]
    repairs = find_repairs(prober.model, name, sorted(functions), source, lambda: False)
    texts = [count_turns(repair.text) for repair in itertools.islice(repairs, MAX_UNDONE)]
    calls = probes.calls[:MAX_ASKED]
    answers = VariantCaller(runner.programs).answers(texts, probes.function, calls, probes.kit) if texts else []
    read = [[probes.read_answer(call, answer) for call, answer in zip(calls, given, strict=False)] for given in answers]
    rights = prober.right_answers_by_style(index)
    return any(_some_right(probes, mine, right) for mine in read for right in rights)


def _some_right(probes: Probes, mine: list[object], right: list[object]) -> bool:
    pairs = zip(mine, right, strict=False)
    return any(not isinstance(answer, ProbeFault) and probes.same(answer, wanted) for answer, wanted in pairs)
