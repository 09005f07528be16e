"""A name on answers that tell little is held against the program itself: the mistake is undone there, and it is run.

A function that fails everywhere, or returns zeros only, answers as several mistakes of the catalogue make it answer.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Collection, Sequence
from functools import partial

from graders.core.code.call_graph import find_callers
from graders.core.code.changes import add_loop_counters
from graders.core.code.prober import Prober
from graders.core.code.probes import ProbeAnswer, ProbeFault, ProbeResults, Probes, ProgramTrial
from graders.core.code.recognised import RecognisedMistakes, RuleName
from graders.core.code.repairs import find_repairs
from graders.core.code.runner import Runner
from graders.core.code.variants import VariantCaller
from graders.core.contract.values import Arguments

#: Places at which a mistake is undone, and probes asked of the program then.
MAX_UNDONE, MAX_ASKED = 40, 6


def verify_weak_names(
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
        elif not _is_mended_by_undoing(name, edits[name], silent.number, prober, runner):
            likely.append(name)
    if not instead and not likely:
        return found
    names = [instead.get(name, (name,)) for name in found.mistakes]
    mistakes = tuple(dict.fromkeys(name for several in names for name in several))
    return found._replace(mistakes=mistakes, certain=False, likely=tuple(likely))


def verify_rule_names(
    found: RecognisedMistakes, prober: Prober | None, runner: Runner, broken_functions: Collection[str]
) -> RecognisedMistakes:
    """Return what was found, each name that a rule has given held against the program by the experiment of its rule.

    A name that its experiment belies gives way to that of a later rule; one that it leaves open is `likely` only. None
    stands in a function that calls one of `broken_functions`: what its answers have in common may come of these.
    """
    if prober is None:
        return found
    instead: dict[str, tuple[str, ...]] = {}
    likely = list(found.likely)
    for ruled in found.ruled:
        function = prober.probes[ruled.number].function
        if function in find_callers(runner.source, [other for other in broken_functions if other != function]):
            instead[ruled.mistake] = ()
            continue
        name, is_open = _choose_borne_out_name(ruled, prober, runner)
        if name != ruled.mistake:
            instead[ruled.mistake] = (name,) if name else ()
        likely += [name] if name and is_open else []
    if not instead and len(likely) == len(found.likely):
        return found
    mistakes, fallback = (
        tuple(dict.fromkeys(name for mistake in names for name in instead.get(mistake, (mistake,))))
        for names in (found.mistakes, found.fallback)
    )
    return found._replace(mistakes=mistakes, fallback=fallback, likely=tuple(likely))


def _choose_borne_out_name(ruled: RuleName, prober: Prober, runner: Runner) -> tuple[str, bool]:
    """Return the first candidate that its experiment bears out, else the first that it leaves open, and whether it is
    such a one; "" where all are belied."""
    edits = {edit.id: edit.functions for edit in prober.model.edits}
    still_open = ""
    for name, experiment in ruled.candidates:
        undo = partial(_is_mended_by_undoing, name, edits.get(name, ()), ruled.number, prober, runner)
        is_borne_out = experiment(_make_program_trial(ruled.number, prober, runner, undo))
        if is_borne_out:
            return name, False
        if is_borne_out is None:
            still_open = still_open or name
    return still_open, True


def _make_program_trial(index: int, prober: Prober, runner: Runner, undo: Callable[[], bool]) -> ProgramTrial:
    probes, source = prober.probes[index], add_loop_counters(runner.source.decode("utf-8-sig", "replace"))

    def ask(calls: Sequence[Arguments]) -> Sequence[ProbeAnswer]:
        (given,) = VariantCaller(runner.programs).call_variants([source], probes.function, calls, probes.kit)
        return [probes.read_answer(call, answer) for call, answer in zip(calls, given, strict=False)]

    def ask_probes() -> ProbeResults:
        answers = ask(probes.calls)
        right = prober.nearest_right_answers(index, answers) if len(answers) == len(probes.calls) else answers
        return ProbeResults(probes.calls, answers, right, probes.same)

    return ProgramTrial(ask_probes, ask, undo)


def _is_mended_by_undoing(name: str, functions: Collection[str], index: int, prober: Prober, runner: Runner) -> bool:
    """Whether some answer becomes right in the program with the mistake undone at some place."""
    source, probes = runner.source.decode("utf-8-sig", "replace"), prober.probes[index]
    repairs = find_repairs(prober.model, name, sorted(functions), source, lambda: False)
    texts = [add_loop_counters(repair.text) for repair in itertools.islice(repairs, MAX_UNDONE)]
    calls = probes.calls[:MAX_ASKED]
    answers = VariantCaller(runner.programs).call_variants(texts, probes.function, calls, probes.kit) if texts else []
    read = [[probes.read_answer(call, answer) for call, answer in zip(calls, given, strict=False)] for given in answers]
    rights = prober.right_answers_by_style(index)
    return any(_has_right_answer(probes, mine, right) for mine in read for right in rights)


def _has_right_answer(probes: Probes, mine: list[object], right: list[object]) -> bool:
    pairs = zip(mine, right, strict=False)
    return any(not isinstance(answer, ProbeFault) and probes.same(answer, wanted) for answer, wanted in pairs)
