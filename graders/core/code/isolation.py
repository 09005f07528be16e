"""Each function of a failed program judged beside right ones: what it fails by itself, and the mistakes named then.

A mistake of one function hides those of the functions that call it, and fells their checks. The exercise's solution
therefore takes the place of all functions but one. Only names of the catalogue, and counts of points, are told of such
programs: their answers are shown to nobody, since they run beside the solution's text.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace

from graders.core.code.call_graph import find_callers
from graders.core.code.checks import Check
from graders.core.code.diagnosis import points_text
from graders.core.code.facts import IMPRECISIONS, is_stated_in_titles
from graders.core.code.grading import CodeGrader, NamedMistakes
from graders.core.code.pair_search import OutOfTimeError
from graders.core.code.related_lines import JudgedFunctions
from graders.core.code.time_limits import TimeLimitedPrograms
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


def solution_override_suffix(grader: CodeGrader, source: str, replaced: Collection[str]) -> str:
    """Return what, behind a program, puts the solution's functions in the place of these.

    They call those of the program's others that the replaced ones call: through any other, a check would fail that the
    program's own functions pass.
    """
    others = [name for name in grader.functions if name not in replaced]
    own = [name for name in others if find_callers(source.encode(), [name]).intersection(replaced)]
    return _SUFFIX.format(solution=grader.solution, own=own, replaced=sorted(replaced))


@dataclass(frozen=True)
class IsolatedFunctions:
    """The mistakes of a whole program, and by function those that it shows beside right ones.

    `functions` are those that can have a mistake of the catalogue, by its id; `dependent`, those that call others.
    """

    whole: NamedMistakes
    own: Mapping[str, NamedMistakes]
    functions: Mapping[str, Collection[str]]
    dependent: frozenset[str] = frozenset()

    def unexplained_functions(self) -> list[str]:
        """Return the functions that fail by themselves without a certain name, those without any name first."""
        functions = [
            name for name, own in self.own.items() if own.failed and not (own.certain or self.is_certain(name))
        ]
        return sorted(functions, key=lambda name: bool(self.own[name].ids))

    def is_certain(self, function: str) -> bool:
        """Whether the whole program already answers as one with mistakes of this function does, and as no other."""
        return self.whole.certain and bool(self.mistakes_of_function(function))

    def mistakes_of_function(self, function: str) -> list[str]:
        """Return the mistakes of the whole program that a function can have, but those that another one shows."""
        elsewhere = {mistake for name, own in self.own.items() if name != function for mistake in own.ids}
        mine = [mistake for mistake in self.whole.ids if function in self.functions.get(mistake, ())]
        return [mistake for mistake in mine if mistake in self.own[function].ids or mistake not in elsewhere]

    def doubtful_checks(self) -> frozenset[str]:
        """Return the checks that fail in the whole program only, for a reason that no function shows by itself."""
        return self.whole.failed.difference(*(mistakes.failed for mistakes in self.own.values()))

    def consequential_checks(self, explained: Collection[str], checks: Sequence[Check]) -> frozenset[str]:
        """Return the checks that fail through other functions only, each with an explained check of its own."""
        functions = {check.id: check.functions for check in checks}
        told = [
            name
            for name, mistakes in self.own.items()
            if any(check in explained and functions[check] == (name,) for check in mistakes.failed)
        ]
        through_told = {check for name in told for check in self.own[name].failed if name not in functions[check]}
        by_others = {check for name, own in self.own.items() for check in own.failed if name not in told}
        by_itself = {check for name, own in self.own.items() for check in own.failed if name in functions[check]}
        return frozenset(through_told - by_others - by_itself)

    def explained_functions(self) -> list[str]:
        """Return the functions that need no search: right by themselves, or with a certain name."""
        return [name for name in self.own if name not in self.unexplained_functions()]

    def judge_functions(self, functions: Sequence[str]) -> JudgedFunctions:
        """Return which of the exercise's functions fail by themselves, and which are right."""
        guilty = self.guilty_functions()
        return JudgedFunctions(guilty, [name for name in functions if name not in guilty] if guilty else [])

    def guilty_functions(self) -> list[str]:
        """Return the functions that fail by themselves; where none does, only their common conventions are wrong."""
        return [name for name, mistakes in self.own.items() if mistakes.failed]


def isolate_failed_functions(
    grader: CodeGrader, source: str, programs: Programs, seed: int, is_time_spent: Callable[[], bool]
) -> IsolatedFunctions | None:
    """Judge each failed function of a program beside right ones; None for one function, or where time runs out."""
    if len(grader.functions) < 2 or is_time_spent():
        return None
    limited = TimeLimitedPrograms(programs, is_time_spent)
    own = {}
    try:
        whole = grader.name_mistakes(source, limited, seed)
        for function in _functions_of_failed_checks(grader, whole.failed):
            others = [name for name in grader.functions if name != function]
            beside = source + solution_override_suffix(grader, source, others)
            own[function] = grader.name_mistakes(beside, limited, seed, is_time_spent, whole.failed)
    except OutOfTimeError:
        return None
    dependent = {
        function for name in own for function in find_callers(source.encode(), [name]) if function in grader.functions
    }
    functions_of = {each.id: each.functions for each in grader.misconceptions}
    return IsolatedFunctions(whole, own, functions_of, frozenset(dependent))


def name_mistakes_in_time(
    grader: CodeGrader, source: str, programs: Programs, seed: int, is_time_spent: Callable[[], bool]
) -> NamedMistakes:
    """Return the mistakes named in a whole program; none where time runs out."""
    try:
        return grader.name_mistakes(source, TimeLimitedPrograms(programs, is_time_spent), seed, is_time_spent)
    except OutOfTimeError:
        return NamedMistakes()


def _functions_of_failed_checks(grader: CodeGrader, failed: Collection[str]) -> list[str]:
    names = {name for check in grader.checks if check.id in failed for name in check.functions}
    return [function for function in grader.functions if function in names]


def diagnose_isolated_functions(
    grader: CodeGrader, isolated: IsolatedFunctions, checks: Sequence[CheckResult]
) -> Diagnosis | None:
    """Return the diagnosis with the mistakes of each function; None where it names the same ones as the whole program.

    Names of a function that fails nothing by itself are withdrawn. Those that one shows beside right ones are added
    where it had none, or replace its uncertain ones where they are certain.
    """
    if not isolated.guilty_functions():
        return None
    whole, own = isolated.whole, isolated.own
    ids = {mistake: explained for mistake in whole.ids if (explained := _checks_still_explained(isolated, mistake))}
    facts = dict(zip(whole.facts, whole.explains[len(whole.ids) :], strict=True))
    shown: dict[str, str] = {}  # by title, the function that shows the mistake beside right ones only
    for function, mistakes in own.items():
        if not isolated.mistakes_of_function(function) or _has_surer_isolated_names(isolated, function):
            for mistake in mistakes.ids:
                if function in isolated.functions.get(mistake, ()) and mistake not in ids:
                    ids[mistake] = mistakes.failed
                    shown[grader.mistake_title(mistake)] = function
        for fact in mistakes.facts:
            if fact.slip.title not in {known.slip.title for known in facts}:
                facts[fact] = tuple(mistakes.failed.intersection(fact.checks))
                shown[fact.slip.title] = function
    facts = {
        fact: told for fact, told in facts.items() if not is_stated_in_titles(fact, map(grader.mistake_title, ids))
    }
    nearly_right = {check for fact, told in facts.items() if fact.slip.id in IMPRECISIONS for check in told}
    unsure = [mistake for mistake in ids if not _is_certain_mistake(isolated, mistake)]
    for mistake in unsure:  # numbers that are nearly right are no other formula: one cause is told, and once
        if ids[mistake] <= nearly_right:
            del ids[mistake]
    if not ids and not facts:
        return None
    if list(ids) == list(whole.ids) and list(facts) == list(whole.facts):
        return None
    explains = tuple(_sort_ids_by_check(checks, explained) for explained in (*ids.values(), *facts.values()))
    certain = not facts and all(own[name].certain or isolated.is_certain(name) for name in isolated.guilty_functions())
    hidden = frozenset(title for title, function in shown.items() if function in isolated.dependent)
    failed = whole.failed - isolated.doubtful_checks()
    grounds = {name: ground for mistakes in (*own.values(), whole) for name, ground in mistakes.grounds.items()}
    answering = _merge_answering([*own.values(), whole])
    return grader.describe_mistakes(
        NamedMistakes(tuple(ids), tuple(facts), explains, certain, failed, hidden, grounds, answering)
    )


def add_lost_points_by_function(
    isolated: IsolatedFunctions, checks: Sequence[CheckResult], diagnosis: Diagnosis
) -> Diagnosis:
    """Return the diagnosis with the points that each function loses by itself."""
    guilty = isolated.guilty_functions()
    innocent = [function for function, mistakes in isolated.own.items() if not mistakes.failed]
    lost = _lost_points(checks, {check.id for check in checks if not (check.passed or check.neutral)})
    told = []
    if len(guilty) > 1:
        shares = [f"{name} {points_text(_lost_points(checks, isolated.own[name].failed))}" for name in guilty]
        shares[0] += f" sur {points_text(lost)}"
        told.append(f"Points perdus, chaque fonction jugée avec les autres justes : {', '.join(shares)}.")
    if innocent:
        names = " et ".join(innocent)
        told.append(f"Avec les autres fonctions justes, {names} n'{'ont' if len(innocent) > 1 else 'a'} rien de faux.")
    explanation = "\n\n".join([diagnosis.explanation, " ".join(told)] if told else [diagnosis.explanation])
    return replace(diagnosis, explanation=explanation)


def _merge_answering(named: Sequence[NamedMistakes]) -> Mapping[str, frozenset[str]]:
    """Return the functions that answer as with a mistake in some of these programs, by its id."""
    ids = {mistake for mistakes in named for mistake in mistakes.answering}
    return {mistake: frozenset().union(*(mistakes.answering.get(mistake, ()) for mistakes in named)) for mistake in ids}


def _is_certain_mistake(isolated: IsolatedFunctions, mistake: str) -> bool:
    """Whether a function that can have a mistake answers as one with its names does, and as no other."""
    functions = [name for name in isolated.own if name in isolated.functions.get(mistake, ())]
    return any(isolated.own[name].certain or isolated.is_certain(name) for name in functions)


def _has_surer_isolated_names(isolated: IsolatedFunctions, function: str) -> bool:
    """Whether the names that a function shows beside right ones are surer than the whole program's."""
    own = isolated.own[function]
    return bool(own.failed and own.ids) and own.certain and not isolated.is_certain(function)


def _contradicts_mistake(isolated: IsolatedFunctions, function: str, mistake: str) -> bool:
    """Whether a function shows no such mistake beside right ones, but surer ones, or others of the whole program."""
    own = isolated.own[function].ids
    return mistake not in own and (
        _has_surer_isolated_names(isolated, function) or not set(own).isdisjoint(isolated.whole.ids)
    )


def _checks_still_explained(isolated: IsolatedFunctions, mistake: str) -> frozenset[str]:
    """Return the checks that a mistake of the whole program explains; none where its functions do not bear it out."""
    functions = [name for name in isolated.own if name in isolated.functions.get(mistake, ())]
    if not functions:
        return frozenset(isolated.whole.explains[isolated.whole.ids.index(mistake)])
    guilty = [name for name in functions if isolated.own[name].failed]
    if guilty and all(_contradicts_mistake(isolated, name, mistake) for name in guilty):
        return frozenset()
    return frozenset().union(*(isolated.own[name].failed for name in guilty))


def _lost_points(checks: Sequence[CheckResult], chosen: Collection[str]) -> float:
    return sum(check.max_points - check.points for check in checks if check.id in chosen)


def _sort_ids_by_check(checks: Sequence[CheckResult], chosen: Collection[str]) -> tuple[str, ...]:
    return tuple(check.id for check in checks if check.id in chosen)
