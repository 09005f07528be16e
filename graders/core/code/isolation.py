"""Each function of a failed program judged beside right ones: what it fails by itself, and the mistakes named then.

A mistake of one function hides those of the functions that call it, and fells their checks. The exercise's solution
therefore takes the place of all functions but one. Only names of the catalogue, and counts of points, are told of such
programs: their answers are shown to nobody, since they run beside the solution's text.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace

from graders.core.code.diagnosis import number_text
from graders.core.code.grading import CodeGrader, NamedMistakes
from graders.core.contract.program import Programs
from graders.core.contract.verdict import CheckResult, Diagnosis

_SUFFIX = """

_reference = dict(globals())
exec(compile({solution!r}, "solution.py", "exec"), _reference)
for _nom in {own!r}:
    if _nom in globals():
        _reference[_nom] = globals()[_nom]
for _nom in {replaced!r}:
    globals()[_nom] = _reference[_nom]
"""


def replacing_suffix(grader: CodeGrader, replaced: Collection[str]) -> str:
    """Return what, behind a program, puts the solution's functions in the place of these, calling its others."""
    own = [name for name in grader.functions if name not in replaced]
    return _SUFFIX.format(solution=grader.solution, own=own, replaced=sorted(replaced))


@dataclass(frozen=True)
class IsolatedFunctions:
    """The mistakes of a whole program, and by function those that it shows beside right ones."""

    whole: NamedMistakes
    own: Mapping[str, NamedMistakes]

    def unexplained(self) -> list[str]:
        """Return the functions that fail by themselves without a certain name, those without any name first."""
        functions = [name for name, mistakes in self.own.items() if mistakes.failed and not mistakes.certain]
        return sorted(functions, key=lambda name: bool(self.own[name].ids))

    def doubtful(self) -> frozenset[str]:
        """Return the checks that fail in the whole program only, for a reason that no function shows by itself."""
        return self.whole.failed.difference(*(mistakes.failed for mistakes in self.own.values()))

    def explained(self) -> list[str]:
        """Return the functions that need no search: right by themselves, or with a certain name."""
        return [name for name in self.own if name not in self.unexplained()]

    def guilty(self) -> list[str]:
        """Return the functions that fail by themselves; where none does, only their common conventions are wrong."""
        return [name for name, mistakes in self.own.items() if mistakes.failed]


def isolate_functions(
    grader: CodeGrader, source: str, programs: Programs, seed: int, spent: Callable[[], bool]
) -> IsolatedFunctions | None:
    """Judge each failed function of a program beside right ones; None for one function, or where time runs out."""
    if len(grader.functions) < 2 or spent():
        return None
    whole = grader.name_mistakes(source, programs, seed)
    own = {}
    for function in _blamed(grader, whole.failed):
        if spent():
            return None
        others = [name for name in grader.functions if name != function]
        named = grader.name_mistakes(source + replacing_suffix(grader, others), programs, seed)
        own[function] = replace(named, failed=named.failed & whole.failed)
    return IsolatedFunctions(whole, own)


def _blamed(grader: CodeGrader, failed: Collection[str]) -> list[str]:
    names = {name for check in grader.checks if check.id in failed for name in check.functions}
    return [function for function in grader.functions if function in names]


def name_isolated(grader: CodeGrader, isolated: IsolatedFunctions, checks: Sequence[CheckResult]) -> Diagnosis | None:
    """Return the diagnosis with the mistakes of each function; None where it names the same ones as the whole program.

    Names of a function that fails nothing by itself are withdrawn, those that it shows beside right ones are added.
    """
    if not isolated.guilty():
        return None
    whole, own = isolated.whole, isolated.own
    ids = {mistake: explained for mistake in whole.ids if (explained := _still_explained(grader, isolated, mistake))}
    facts = dict(zip(whole.facts, whole.explains[len(whole.ids) :], strict=True))
    for function, mistakes in own.items():
        for mistake in mistakes.ids:
            if function in _functions(grader, mistake):
                ids.setdefault(mistake, mistakes.failed)
        for fact in mistakes.facts:
            if fact.slip.title not in {known.slip.title for known in facts}:
                facts[fact] = tuple(mistakes.failed.intersection(fact.checks))
    if not ids and not facts:
        return None
    if list(ids) == list(whole.ids) and list(facts) == list(whole.facts):
        return None
    explains = tuple(_in_order(checks, explained) for explained in (*ids.values(), *facts.values()))
    certain = all(mistakes.certain for mistakes in own.values() if mistakes.failed) and not facts
    return grader.describe_mistakes(NamedMistakes(tuple(ids), tuple(facts), explains, certain))


def tell_shares(isolated: IsolatedFunctions, checks: Sequence[CheckResult], diagnosis: Diagnosis) -> Diagnosis:
    """Return the diagnosis with the points that each function loses by itself."""
    guilty = isolated.guilty()
    innocent = [function for function, mistakes in isolated.own.items() if not mistakes.failed]
    lost = _points(checks, {check.id for check in checks if not check.passed})
    told = []
    if len(guilty) > 1:
        shares = [f"{name} {number_text(_points(checks, isolated.own[name].failed))}" for name in guilty]
        shares[0] += f" sur {number_text(lost)}"
        told.append(f"Points perdus, chaque fonction jugée avec les autres justes : {', '.join(shares)}.")
    if innocent:
        names = " et ".join(innocent)
        told.append(f"Avec les autres fonctions justes, {names} n'{'ont' if len(innocent) > 1 else 'a'} rien de faux.")
    explanation = "\n\n".join([diagnosis.explanation, " ".join(told)] if told else [diagnosis.explanation])
    return replace(diagnosis, explanation=explanation)


def _still_explained(grader: CodeGrader, isolated: IsolatedFunctions, mistake: str) -> frozenset[str]:
    """Return the checks that a mistake of the whole program explains; none where its functions do not bear it out."""
    functions = [name for name in isolated.own if name in _functions(grader, mistake)]
    if not functions:
        return frozenset(isolated.whole.explains[isolated.whole.ids.index(mistake)])
    guilty = [isolated.own[name] for name in functions if isolated.own[name].failed]
    if guilty and all(mistakes.ids and mistake not in mistakes.ids for mistakes in guilty):
        return frozenset()
    return frozenset().union(*(mistakes.failed for mistakes in guilty))


def _functions(grader: CodeGrader, mistake: str) -> frozenset[str]:
    return frozenset(name for each in grader.misconceptions if each.id == mistake for name in each.functions)


def _points(checks: Sequence[CheckResult], chosen: Collection[str]) -> float:
    return sum(check.max_points - check.points for check in checks if check.id in chosen)


def _in_order(checks: Sequence[CheckResult], chosen: Collection[str]) -> tuple[str, ...]:
    return tuple(check.id for check in checks if check.id in chosen)
