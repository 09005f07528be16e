"""The verdict (contract, section 3) in words and tables."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from uuid import UUID

from graders.core.contract.headline import headline
from graders.core.contract.outcomes import Blame, Kind, Outcome
from graders.core.contract.program import KitSettings
from graders.core.contract.verdict import TEACHER, CheckResult, Counterexample, Diagnosis, Verdict
from graders.typography import french
from server.course import FunctionSpec
from server.web import values
from server.web.replay_code import write_replay_code
from server.web.schemas import (
    CheckView,
    CounterexampleView,
    DiagnosisView,
    ExerciseTexts,
    FigureView,
    FilmView,
    Tone,
    VerdictView,
)
from server.web.words import format_mark, format_points

#: What figures show in words, by their names.
Described = Mapping[str, str]
NOT_DESCRIBED: Described = MappingProxyType({})
#: The address under which figures are drawn, the grading that they are of, and what they show.
Figures = tuple[str, UUID | None, Described]
#: The address under which films are made replays, and the checks that have one.
Films = tuple[str, Collection[str]]
NO_FILMS: Films = ("", ())
#: The address that replays a counterexample line by line, and the checks of which it can.
Replayed = tuple[str, Collection[str]]
NOT_REPLAYED: Replayed = ("", ())
#: The kit's settings under which checks ran, and the exercise's solution, which shows whether they matter.
World = tuple[KitSettings | None, str]
NO_WORLD: World = (None, "")
NAME = re.compile(r"[^\W\d]\w*")
TIMINGS = {
    "load_ms": "chargement de votre fichier",
    "checks_ms": "vérifications",
    "diagnosis_ms": "recherche de l’erreur",
    "total_ms": "durée totale",
}


def build_verdict_view(
    verdict: Verdict,
    figures: str,
    texts: ExerciseTexts | None = None,
    functions: Sequence[FunctionSpec] = (),
    *,
    grading: UUID | None = None,
    described: Described = NOT_DESCRIBED,
    films: Films = NO_FILMS,
    replayed: Replayed = NOT_REPLAYED,
    world: World = NO_WORLD,
) -> VerdictView:
    """Lay out a verdict. `figures` is the address under which its figures are drawn.

    Those addresses name the `grading`: browsers keep a figure for ever, and another grading may come to count. So do
    those of `films`. `described` is what they show, for whoever does not see them.

    `texts` is the exercise, where it is answered without code: the verdict's texts are then its Markdown. `functions`
    are those that it asks for: they name the parts of what they return. `world` are the kit's settings of its checks.
    """
    marked = texts is not None
    wording = verdict.outcome.wording("answers") if marked else headline(verdict)
    return VerdictView(
        title=wording.title,
        sentence=wording.sentence,
        tone=_choose_tone(verdict),
        points=format_mark(verdict.points) if verdict.outcome.counts else "",
        common=message_shared_by_checks(verdict.checks),
        checks=tuple(
            _build_check_view(check, (figures, grading, described), marked, functions, films[1], replayed, world)
            for check in verdict.checks
        ),
        diagnosis=_build_diagnosis_view(verdict.diagnosis) if verdict.diagnosis else None,
        stdout=verdict.stdout,
        timings=tuple(_format_timing(name, value) for name, value in verdict.timings.items()),
        seed=str(verdict.seed),
        version=verdict.exercise_version,
        texts=texts,
        films=_build_film_views(verdict.checks, films, grading),
        remarks=tuple(verdict.remarks),
    )


def outcome_in_words(outcome: str | None, kind: Kind = "code") -> str:
    """The outcome of that name in words; « en cours » while there is none."""
    return Outcome(outcome).wording(kind).title if outcome else "En cours de correction"


def _choose_tone(verdict: Verdict) -> Tone:
    if verdict.outcome.blame is Blame.STUDENT:
        return "partial" if verdict.score >= 0.5 else "bad"
    return "ours" if verdict.outcome.blame is Blame.OURS else "good"


def message_shared_by_checks(checks: Sequence[CheckResult]) -> str:
    """Return the message that all checks share, as when the file did not load; shown once."""
    if len(checks) < 2 or any(check.repeats != checks[0].id for check in checks[1:]):
        messages = {check.message for check in checks}
        return messages.pop() if len(messages) == 1 and len(checks) > 1 else ""
    return checks[0].message


def _build_film_views(checks: Sequence[CheckResult], films: Films, grading: UUID | None) -> tuple[FilmView, ...]:
    folder, filmed = films
    ending = f"?correction={grading}" if grading else ""
    first_failed = sorted((check for check in checks if check.id in filmed), key=lambda check: check.passed)
    return tuple(
        FilmView(check.id, check.title, check.passed, f"{folder}/{check.id}{ending}") for check in first_failed
    )


def _build_check_view(
    check: CheckResult,
    figures: Figures,
    marked: bool,
    functions: Sequence[FunctionSpec],
    filmed: Collection[str],
    replayed: Replayed,
    world: World,
) -> CheckView:
    counterexample = check.counterexample
    address, which = replayed
    return CheckView(
        id=check.id,
        title=check.title,
        passed=check.passed,
        points=format_mark(check.points, check.max_points),
        max_points=format_points(check.max_points),
        message=check.message,
        hint=check.hint or "",
        counterexample=_build_counterexample_view(
            counterexample, functions, _world_settings_of_check(check, world), shows_inputs=not marked
        )
        if counterexample
        else None,
        figure=_build_figure_view(check, figures) if check.figure else None,
        filmed=check.id in filmed,
        replay=address if check.id in which else "",
        repeats=bool(check.repeats),
        neutral=check.neutral,
    )


def _build_counterexample_view(
    counterexample: Counterexample, functions: Sequence[FunctionSpec], world: World, *, shows_inputs: bool
) -> CounterexampleView:
    """Without code the data stand in the statement: they are not told again with each answer."""
    given = counterexample.inputs if shows_inputs else {}
    judged = counterexample.expected is not None or counterexample.got is not None
    parts = _names_of_returned_parts(given, functions)
    expected, got = values.build_value_view_pair(counterexample.expected, counterexample.got)
    return CounterexampleView(
        inputs=tuple((name, values.build_value_view(value, short=True)) for name, value in given.items()),
        expected=values.name_items_of_list(expected, parts) if judged and counterexample.has_expected else None,
        got=values.name_items_of_list(got, parts) if judged else None,
        code=write_replay_code(given, functions, *world),
    )


def _world_settings_of_check(check: CheckResult, world: World) -> World:
    """Return the settings of a check, which may have run on another map than the others."""
    kit, solution = world
    if check.kit is None or kit is None:
        return world
    return replace(kit, parameters={**kit.parameters, **check.kit}), solution


def _names_of_returned_parts(given: Mapping[str, object], functions: Sequence[FunctionSpec]) -> tuple[str, ...]:
    """The names of what is returned by the one function that takes the inputs of those names; none if in doubt."""
    takers = [function for function in functions if given and given.keys() <= set(NAME.findall(function.signature))]
    return takers[0].parts if len(takers) == 1 else ()


def _build_figure_view(check: CheckResult, figures: Figures) -> FigureView:
    folder, grading, described = figures
    address = f"{folder}/{check.figure}.svg?{f'correction={grading}&' if grading else ''}theme="
    shown = described.get(check.figure or "", "Votre résultat superposé à la référence.")
    alt = f"Figure de la vérification « {check.title} ». {shown}"
    return FigureView(address + "light", address + "dark", french(alt), french(shown))


def _build_diagnosis_view(diagnosis: Diagnosis) -> DiagnosisView:
    paragraphs = tuple(part.strip() for part in diagnosis.explanation.split("\n\n") if part.strip())
    return DiagnosisView(diagnosis.id, diagnosis.title, paragraphs, diagnosis.source == TEACHER)


def _format_timing(name: str, milliseconds: float) -> tuple[str, str]:
    return TIMINGS.get(name, name), f"{round(milliseconds)}\u00a0ms"
