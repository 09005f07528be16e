"""Findings of declared checks, and their counterexamples."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from graders.core.compare.python_values import to_counterexample_value
from graders.core.compare.slips import SLIPS
from graders.core.compare.told_apart import remove_noise_from_pair
from graders.core.compare.words import to_jsonable
from graders.core.contract.findings import FigureData, Finding
from graders.core.contract.outcomes import Outcome
from graders.core.contract.program import StudentFault
from graders.core.contract.values import Value
from graders.core.contract.verdict import CheckResult, Counterexample, Diagnosis
from graders.core.declared.declaration import DeclaredCheck
from graders.core.declared.judging import FailedCase
from graders.core.declared.scenario_values import FunctionSource, Reference, value_text
from graders.core.declared.scenarios import Scenario, Statement


def _value_to_show(value: Value) -> Value:
    if isinstance(value, FunctionSource | Reference):
        return value_text(value)
    return to_counterexample_value(value) if not isinstance(value, list | tuple | dict) else _container_to_show(value)


def _container_to_show(value: Value) -> Value:
    kept = to_counterexample_value(value)
    holds_function = isinstance(value, list | tuple) and any(isinstance(item, FunctionSource) for item in value)
    return ", ".join(map(value_text, value)) if holds_function else kept


def describe_case(scenario: Scenario) -> str:
    """Return with which input a program is run: « Quand on tape « 3 », puis « 4 » », « Avec somme() »."""
    if not scenario.runs_program:
        return f"Avec {scenario.text()}"
    lines = [f"« {line} »" for line in scenario.typed_lines or ()]
    typed = ", puis ".join(lines) if len(lines) < 4 else ", ".join(lines)
    files = [f"« {step.typed_arguments[0]} »" for step in scenario.statements if step.kind == "file"]
    files += [f"« {name} »" for name, _ in scenario.files]
    with_files = f" avec {', '.join(files)}" if files else ""
    arguments = [f"« {text} »" for step in scenario.statements if step.kind == "argv" for text in step.typed_arguments]
    with_files += f" avec les arguments {', '.join(arguments)}" if arguments else ""
    return f"Quand on tape {typed}{with_files}" if lines else f"Quand on lance le programme{with_files}"


def failure_message(check: DeclaredCheck, failure: FailedCase, statement: Statement, texts: tuple[str, str]) -> str:
    """Return what a failing case says: `texts` are what is expected and what is obtained in this statement."""
    scenario, (expected, obtained) = failure.case.scenario, texts
    if check.watched != "value":
        what = "l’affichage " if check.watched == "printed" else "les fichiers "
        verb = "c’est" if check.watched == "printed" else "ce sont"
        if failure.got.raised or failure.right.raised:
            what, verb = "", "c’est"
        return f"{describe_case(scenario)}, on attend {what}{expected}, et {verb} {obtained}."
    if len(scenario.statements) == 1:
        verb = "lève" if failure.got.raised else "renvoie"
        name = statement.called_name or scenario.called_program_name
        return f"Pour {scenario.text()}, on attend {expected} et {name} {verb} {obtained}."
    if failure.right.raised:  # a fault does not say which of the statements raised it
        returned = statement.is_shown and not failure.got.raised
        return f"Dans « {scenario.text()} », on attend {expected}" + (
            f" et {statement.text()} renvoie {obtained}." if returned else "."
        )
    return f"Dans « {scenario.text()} », {statement.text()} doit donner {expected} et donne {obtained}."


def failed_finding(
    check: DeclaredCheck,
    message: str,
    *,
    inputs: Mapping[str, Value] | None = None,
    expected: Value = None,
    got: Value = None,
    cause: Outcome = Outcome.WRONG_ANSWER,
    slip: str | None = None,
    sign: object = None,
    figure: FigureData | None = None,
    case: Scenario | None = None,
) -> Finding:
    """Return the finding of a failed check; `case` is the one that shows it, `figure` what is drawn of it."""
    counterexample = None
    if inputs is not None:
        shown = {name: to_jsonable(_value_to_show(value)) for name, value in inputs.items()}
        pair = remove_noise_from_pair(to_jsonable(_value_to_show(expected)), to_jsonable(_value_to_show(got)))
        counterexample = Counterexample(shown, *pair)
    result = CheckResult(
        id=check.id,
        title=check.title,
        passed=False,
        points=0,
        max_points=check.points,
        message=message,
        counterexample=counterexample,
        hint=(check.hint or None) if cause is Outcome.WRONG_ANSWER else None,
        figure=None if figure is None else check.id,
        cause=None if cause is Outcome.WRONG_ANSWER else cause,
        case=None if case is None else case.exact_text(),
    )
    return Finding(result, cause, slip, figure, None if sign is None else str(sign))


def fault_finding(
    check: DeclaredCheck,
    fault: StudentFault,
    *,
    inputs: Mapping[str, Value] | None = None,
    expected: Value = None,
    case: Scenario | None = None,
) -> Finding:
    where = "".join(f"\n  {frame}" for frame in fault.frames)
    got = f"aucune valeur ({fault.exception})" if fault.exception else "aucune valeur"
    finding = failed_finding(
        check, fault.message + where, inputs=inputs, expected=expected, cause=fault.outcome, case=case,
        sign=(fault.outcome.value, fault.exception, fault.line) if fault.line else fault.message,
    )  # fmt: skip
    example = finding.result.counterexample
    if example is None:
        return finding
    return replace(finding, result=replace(finding.result, counterexample=replace(example, got=got)))


def slip_diagnosis(findings: Sequence[Finding]) -> Diagnosis | None:
    slip = next((finding.slip for finding in findings if finding.slip), None)
    if slip is None:
        return None
    words = SLIPS[slip]
    return Diagnosis(words.id, words.title, f"{words.explanation}\n\n{words.question}")
