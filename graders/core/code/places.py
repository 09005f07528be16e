"""Words for the places of mistakes that `mending` has found: the line, what it shows there, and a question.

They never tell the change that mends the program: the line and the kind of thing to look at are the student's to read.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from graders.core.code.call_graph import find_callers, find_shared_helpers
from graders.core.code.checks import Check
from graders.core.code.diagnosis import EXPLAINS, FAILS_TOO, OTHERS_FAIL, add_unexplained_checks, lowercase_title
from graders.core.code.experiments import Experimenter
from graders.core.code.grading import CodeGrader
from graders.core.code.isolation import (
    IsolatedFunctions,
    add_lost_points_by_function,
    diagnose_isolated_functions,
    isolate_failed_functions,
    name_mistakes_in_time,
    solution_override_suffix,
)
from graders.core.code.mending import Mending, MendingSearch, repeatable_failures
from graders.core.code.place_words import LOOK, PLACE, describe_place, list_places
from graders.core.code.probes import is_message_self_explanatory
from graders.core.code.related_lines import NOT_JUDGED, JudgedFunctions
from graders.core.code.seen_facts import FactKind, SeenFact
from graders.core.compare import words as render
from graders.core.contract.program import Programs
from graders.core.contract.values import Arguments
from graders.core.contract.verdict import AND_ALSO, CheckResult, Diagnosis, Verdict

EXPERIMENT, SEEN_ALSO = "essais", "Ce que montrent d’autres essais"
#: Values, and facts beside the first, that are told.
MAX_VALUES, MAX_FACTS = 2, 2


@dataclass(frozen=True)
class FoundPlace:
    """The places of a program's mistakes in words, and the kinds of the changes that mend it, for authors."""

    diagnosis: Diagnosis
    changes: str


def is_worth_searching(verdict: Verdict) -> bool:
    """Whether a verdict leaves something to be found: no name, one that is not certain, or checks without one."""
    at_fault = [check for check in verdict.checks if not (check.passed or check.neutral)]
    failed = {check.id for check in at_fault}
    if not failed or verdict.load_error or all(map(_is_self_explanatory, at_fault)):
        return False
    named = verdict.diagnosis
    if named is None:
        return True
    explained = [check for checks in named.explains for check in checks]
    is_told_twice = len(explained) > len(set(explained))
    return not named.certain or is_told_twice or not failed <= set(explained)


def _is_self_explanatory(check: CheckResult) -> bool:
    """Whether a failed check tells an exception that says what is wrong, or repeats another one."""
    return bool(check.repeats) or is_message_self_explanatory(check.message)


def diagnose_mendings(
    mendings: Sequence[Mending], source: str, checks: Sequence[CheckResult], values: Mapping[int, str] | None = None,
    functions: JudgedFunctions = NOT_JUDGED,
) -> Diagnosis:  # fmt: skip
    """Return the diagnosis of the places found; `values` are what is worth seeing at a line, in French."""
    titles, failed = _titles_by_id(checks), _failed_ids(checks)
    places = list_places(mendings)
    first, *others = [describe_place(place, source, titles, values or {}, failed, functions) for place in places]
    paragraphs = [first.explanation, first.question]
    for other in others:
        paragraphs += [f"{other.title}. {other.explanation}", other.question]
    paragraphs += [_last_step_text(named) for named in _names_of_last_steps(mendings)]
    title = AND_ALSO.join([first.title, *(lowercase_title(other.title) for other in others)])
    explains = tuple(tuple(sorted(place.mended)) for place in places)
    return add_unexplained_checks(
        Diagnosis(PLACE, title, "\n\n".join(paragraphs), None, explains),
        checks,
        besides=_checks_named_by_last_steps(mendings),
        mended=_mended_with_own_functions(mendings),
    )


def _titles_by_id(checks: Sequence[CheckResult]) -> dict[str, str]:
    return {check.id: check.title for check in checks}


def _failed_ids(checks: Sequence[CheckResult]) -> set[str]:
    return {check.id for check in checks if not (check.passed or check.neutral)}


def find_place(
    grader: CodeGrader, source: str, verdict: Verdict, programs: Programs, spent: Callable[[], bool]
) -> FoundPlace | None:
    """Search the places of a failed program's mistakes; None where it is not worth it, or none is found.

    Names that the functions show one by one are told instead of the verdict's.
    """
    if not is_worth_searching(verdict) and not _may_hide_others(grader, verdict):
        return None
    isolated = isolate_failed_functions(grader, source, programs, verdict.seed, spent)
    named, functions = None, _unexplained_functions(grader, verdict)
    if isolated is not None and isolated.guilty_functions():
        named = diagnose_isolated_functions(grader, isolated, verdict.checks)
        functions = isolated.unexplained_functions()
    elif functions and len(grader.functions) == 1:
        pair = name_mistakes_in_time(grader, source, programs, verdict.seed, spent)
        if pair.ids and pair.certain and not pair.facts:
            named, functions = grader.describe_mistakes(pair), []
    facts, mendings, values = [], list[Mending](), dict[int, str]()
    if functions:
        calls = _example_calls(grader, verdict)
        examples = {name: [call for _, of, call in calls if of == name] for name in functions}
        facts = Experimenter(grader, programs, verdict.seed, spent, examples).find_facts(
            source, _functions_calling_no_guilty_one(functions, source, isolated)
        )
        mendings = _search_mendings(grader, source, verdict, programs, spent, functions, isolated)
        if mendings and calls:
            line, (title, function, arguments) = mendings[0].steps[0].change.line, calls[0]
            looking = MendingSearch(grader, programs, verdict.seed, spent)
            if words := _values_text(looking.values_at(source, line, function, arguments)):
                values[line] = f"Dans l'exemple de « {title} », {words}."
    if any(not mending.left for mending in mendings):  # a line is told that alone mends all: this would lead away
        facts = [fact for fact in facts if fact.kind is not FactKind.CONTRAST]
    steps = [step for mending in mendings for step in mending.steps]
    operators = " ; ".join(step.change.operator or step.change.mistake for step in steps)
    judged = NOT_JUDGED if isolated is None else isolated.judge_functions(grader.functions)
    found = _combine_findings(grader, verdict, source, named, mendings, values, facts, judged)
    if isolated is not None and isolated.guilty_functions():
        found = found or (verdict.diagnosis if len(isolated.guilty_functions()) > 1 else None)
        if found is not None:
            found = add_lost_points_by_function(isolated, verdict.checks, _remove_remainder_text(found))
            explained = {check for ids in found.explains for check in ids}
            doubtful = isolated.doubtful_checks() | isolated.consequential_checks(explained, grader.checks)
            last = _checks_named_by_last_steps(mendings)
            mended = _mended_with_own_functions(mendings)
            found = add_unexplained_checks(found, verdict.checks, doubtful, besides=last, mended=mended, is_quoted=True)
    return None if found is None or found == verdict.diagnosis else FoundPlace(found, operators)


def _functions_calling_no_guilty_one(
    functions: Sequence[str], source: str, isolated: IsolatedFunctions | None
) -> list[str]:
    """Return the functions that call no other one at fault: what is seen of their answers is theirs alone."""
    guilty = [] if isolated is None else isolated.guilty_functions()
    return [name for name in functions if name not in find_callers(source.encode(), set(guilty) - {name})]


def _search_mendings(
    grader: CodeGrader, source: str, verdict: Verdict, programs: Programs, spent: Callable[[], bool],
    functions: Sequence[str], isolated: IsolatedFunctions | None,
) -> list[Mending]:  # fmt: skip
    """Return the changes that mend these functions: each of them beside right ones, where each is known by itself.

    In a program with mistakes in several functions, a change of a right line may make up for the mistake of another.
    What several functions share comes first: one change there may mend them all.
    """
    failed = repeatable_failures(source, verdict)
    if isolated is None or not isolated.guilty_functions():
        mending = MendingSearch(grader, programs, verdict.seed, spent).find_mending(source, functions, failed=failed)
        return [] if mending is None else [mending]

    def beside_right_ones(chosen: Collection[str], helpers: Collection[str] = ()) -> Mending | None:
        others = frozenset(isolated.guilty_functions()).difference(chosen)
        suffix = solution_override_suffix(grader, source, others) if others else ""
        apart = isolated.own.keys() - set(chosen)
        search, known = MendingSearch(grader, programs, verdict.seed, spent, suffix, apart), () if suffix else failed
        return search.find_mending(source, chosen, helpers, known)

    guilty = [name for name in functions if isolated.own[name].failed]
    if helpers := find_shared_helpers(source.encode(), guilty, grader.functions):
        shared = beside_right_ones(guilty, helpers)
        if shared is not None and not shared.left:
            return [shared]
    found = (beside_right_ones([name]) for name in functions)
    return [mending for mending in found if mending is not None]


def _may_hide_others(grader: CodeGrader, verdict: Verdict) -> bool:
    """Whether names may be consequences, or hide others: several names, or a failed check of other functions too."""
    titles = verdict.diagnosis.titles if verdict.diagnosis is not None else ()
    if len(titles) > 1:
        return True
    named = {name for each in grader.misconceptions if each.title in titles for name in each.functions}
    failed = {
        check.id for check in verdict.checks if not (check.passed or check.neutral or _is_self_explanatory(check))
    }
    return any(check.id in failed and named and not named.issuperset(check.functions) for check in grader.checks)


def _combine_findings(
    grader: CodeGrader, verdict: Verdict, source: str, named: Diagnosis | None, mendings: Sequence[Mending],
    values: Mapping[int, str], facts: Sequence[SeenFact], functions: JudgedFunctions,
) -> Diagnosis | None:  # fmt: skip
    """Return one diagnosis of a program's names, places and facts; None where the verdict tells as much."""
    known = named or verdict.diagnosis
    place = diagnose_mendings(mendings, source, verdict.checks, values, functions) if mendings else None
    if place is not None and known is not None and not _is_disproved(known, place):
        known = named = _add_places_to_diagnosis(known, mendings, source, verdict.checks, values, functions)
    elif place is not None:
        known = named = place
    if named is not None:
        return _add_facts_to_diagnosis(named, facts)
    return diagnose_facts(facts, grader.checks, verdict.checks) if facts else None


def _add_places_to_diagnosis(
    named: Diagnosis, mendings: Sequence[Mending], source: str, checks: Sequence[CheckResult],
    values: Mapping[int, str], functions: JudgedFunctions,
) -> Diagnosis:  # fmt: skip
    """Return named mistakes with the places found: another mistake where one mends checks that no name explains."""
    titles, failed = _titles_by_id(checks), _failed_ids(checks)
    explained = {check for ids in named.explains for check in ids}
    named = _remove_remainder_text(named)
    lines = set[int]()
    for found in list_places(mendings):
        if found.changed_lines[0] in lines:
            continue
        lines.add(found.changed_lines[0])
        is_explained = found.mended <= explained
        place = describe_place(found, source, titles, values, failed, None if is_explained else functions)
        if is_explained:
            where = place.explanation.partition(LOOK)[0].strip()
            told = f"Dans votre programme : {lowercase_title(place.title)}. {where}"
        else:
            told = f"{place.title}. {place.explanation}\n\n{place.question}"
            title = f"{named.title}{AND_ALSO}{lowercase_title(place.title)}"
            explains = (*named.explains, tuple(sorted(found.mended - explained)))
            named = replace(named, title=title, explains=explains, certain=False)
        named = replace(named, explanation=f"{named.explanation}\n\n{told}")
    for last in _names_of_last_steps(mendings):
        if last.title not in named.titles:
            named = replace(named, explanation=f"{named.explanation}\n\n{_last_step_text(last)}")
    return add_unexplained_checks(
        named, checks, besides=_checks_named_by_last_steps(mendings), mended=_mended_with_own_functions(mendings)
    )


def _names_of_last_steps(mendings: Sequence[Mending]) -> list[Diagnosis]:
    return [mending.last_name for mending in mendings if mending.last_name is not None]


def _last_step_text(named: Diagnosis) -> str:
    return f"Ce qui reste, une fois l'autre ligne écrite autrement : {named.title}. {named.explanation}"


def _checks_named_by_last_steps(mendings: Sequence[Mending]) -> set[str]:
    """Return the checks that the names of what the last steps mend explain: they do not remain."""
    return {check for name in _names_of_last_steps(mendings) for ids in name.explains for check in ids}


def _mended_with_own_functions(mendings: Sequence[Mending]) -> frozenset[str]:
    """Return the checks that the changed program passes with its own functions."""
    return frozenset().union(*(mending.mended_checks for mending in mendings if not mending.beside_right_ones))


def _remove_remainder_text(diagnosis: Diagnosis) -> Diagnosis:
    """Return a diagnosis without what `add_unexplained_checks` has added to it."""
    left = [
        text for text in diagnosis.explanation.split("\n\n") if not text.startswith((EXPLAINS, FAILS_TOO, OTHERS_FAIL))
    ]
    return replace(diagnosis, explanation="\n\n".join(left))


def _unexplained_functions(grader: CodeGrader, verdict: Verdict) -> list[str]:
    """Return the functions of the failed checks that no certain name explains; those without any name come first."""
    named = verdict.diagnosis
    explained = {check for checks in named.explains for check in checks} if named is not None and named.certain else ()
    failed = {check.id for check in verdict.checks if not (check.passed or check.neutral or check.id in explained)}
    blamed = {name for check in grader.checks if check.id in failed for name in check.functions}
    told = {check for checks in named.explains for check in checks} if named is not None else set()
    without_name = {name for check in grader.checks if check.id in failed - told for name in check.functions}
    functions = [function for function in grader.functions if function in blamed]
    return sorted(functions, key=lambda name: name not in without_name)


def diagnose_facts(facts: Sequence[SeenFact], checks: Sequence[Check], results: Sequence[CheckResult]) -> Diagnosis:
    """Return the diagnosis of what experiments have established, where no place is known."""
    first, *others = facts
    found = Diagnosis(EXPERIMENT, first.title, f"{first.proof}\n\n{first.question}")
    failed = {result.id for result in results if not result.passed}
    shown = {fact.function for fact in facts}
    explains = tuple(check.id for check in checks if check.id in failed and shown.intersection(check.functions))
    return replace(_add_facts_to_diagnosis(found, others), explains=(explains,))


def _add_facts_to_diagnosis(found: Diagnosis, facts: Sequence[SeenFact]) -> Diagnosis:
    told = [f"{SEEN_ALSO} : {fact.title}. {fact.proof}" for fact in facts[:MAX_FACTS]]
    return replace(found, explanation="\n\n".join([found.explanation, *told]))


def _example_calls(grader: CodeGrader, verdict: Verdict) -> list[tuple[str, str, Arguments]]:
    """Return the calls that failed checks show: the check's title, the function and the arguments."""
    checks = {check.id: check for check in grader.checks if check.reports_call and len(check.functions) == 1}
    calls = []
    for result in verdict.checks:
        if not result.passed and result.counterexample is not None and result.id in checks:
            inputs = result.counterexample.inputs.values()
            arguments = tuple(np.array(value, dtype=float) if _is_array_like(value) else value for value in inputs)
            calls.append((result.title, checks[result.id].functions[0], arguments))
    return calls


def _is_array_like(value: Any) -> bool:
    try:
        return isinstance(value, list) and np.array(value, dtype=float).size > 0
    except (ValueError, TypeError):
        return False


def _values_text(values: Sequence[tuple[str, float]]) -> str:
    told = [f"{name} y vaut {render.text(value)}" for name, value in values if math.isfinite(value)]
    return " et ".join(told[:MAX_VALUES])


def add_place_to_diagnosis(diagnosis: Diagnosis | None, place: Diagnosis) -> Diagnosis:
    """Return a verdict's diagnosis with the places that were found since.

    Several mistakes that are told of the same checks give way to one place that alone makes all of them pass: a program
    with two mistakes may answer alike by chance.
    """
    if diagnosis is None or _is_disproved(diagnosis, place):
        return place
    if place.id not in (PLACE, EXPERIMENT):
        if diagnosis.source is None:
            return place
        told = f"{SEEN_ALSO} : {lowercase_title(place.title)}. {place.explanation}"
        return replace(diagnosis, explanation=f"{diagnosis.explanation}\n\n{told}")
    where = place.explanation.partition("\n\n")[0].partition(LOOK)[0].strip()
    if place.id == EXPERIMENT:
        others = [text for text in place.explanation.split("\n\n") if text.startswith(SEEN_ALSO)]
        paragraphs = [diagnosis.explanation, f"{SEEN_ALSO} : {place.title}. {where}", *others]
        return replace(diagnosis, explanation="\n\n".join(paragraphs))
    told = f"Dans votre programme : {lowercase_title(place.title)}. {where}"
    return replace(diagnosis, explanation=f"{diagnosis.explanation}\n\n{told}")


def _is_disproved(diagnosis: Diagnosis, place: Diagnosis) -> bool:
    """Whether one place mends all that several mistakes, or one that is only likely, are told to explain."""
    together = {frozenset(checks) for checks in diagnosis.explains}
    is_one = len(place.explains) == 1 and (len(diagnosis.titles) > 1 or diagnosis.is_likely)
    return is_one and diagnosis.source is None and all(checks <= set(place.explains[0]) for checks in together)
