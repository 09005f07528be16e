"""From a draft to a declaration: what the author leaves out is proposed.

Nothing of the author's runs here; `ExerciseTrial` asks the sandbox what the solution answers.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from graders.core.contract.verdict import MAX_POINTS
from graders.core.declared import proposals
from graders.core.declared.case_reading import parse_scenario
from graders.core.declared.declaration import is_whole_program
from graders.core.declared.imports import read_imports
from graders.core.declared.malformed import MalformedDeclaration
from graders.core.declared.proposals import ProposedDraws
from graders.core.declared.scenarios import PROGRAM, Scenario
from graders.core.declared.tolerances import propose_tolerance
from graders.core.declared.trial import ExerciseTrial
from graders.core.declared.wording import describe_case
from graders.core.syntax_trees import evaluate_literal
from graders.typography import unaccented
from server.studio.drafts import (
    CHECK_CHOICES,
    CHECK_FLAGS,
    CHECK_NUMBERS,
    CHECK_TEXTS,
    EXAMPLES_TITLE,
    MORE_EXAMPLES_TITLE,
    CaseDraft,
    CheckDraft,
    ExerciseDraft,
    MistakeDraft,
)

DRAWN_TITLE = "D’autres entrées, tirées au hasard"
#: The share of the points that proposed draws take from the examples.
DRAWN_POINTS = 8.0
#: Keys of a check that say how its answers are compared; drawn inputs that a proposal shows.
SHARED_KEYS, SHOWN_DRAWS = ("tolerance", "absolue", "ordre", "types_stricts"), 3
FILE_LINE = re.compile(r"^===[ \t]*(\S.*?)[ \t]*$", re.M)
#: Examples that are added below a statement, and characters of what each of them gives.
SHOWN_EXAMPLES = 12
MAX_SHOWN = 200
NOT_A_WORD = re.compile(r"[^a-z0-9]+")


@dataclass(frozen=True)
class CompletedExercise:
    """A draft with its proposals: `declaration` is what the engine reads.

    `draws`, `call` and `conditions` are draws that are proposed, and not in the declaration; `drawn` are some of these
    inputs, with the solution's answers. All are empty where nothing is proposed.
    """

    title: str
    summary: str
    statement: str
    starter: str
    signatures: dict[str, str]
    hints: tuple[str, ...]
    declaration: dict[str, Any]
    draws: str = ""
    call: str = ""
    conditions: tuple[str, ...] = ()
    drawn: tuple[tuple[str, str], ...] = ()


def complete_draft(draft: ExerciseDraft, trial: ExerciseTrial) -> CompletedExercise:
    """Return the exercise that a draft makes, whether the engine can read it or not."""
    draft = draft.without_empty_parts()
    solution = _unix_newlines(draft.solution).rstrip() + "\n"
    calls = [case.call for check in draft.checks for case in check.nonempty_cases]
    functions = draft.functions.replace(",", " ").split() or proposals.propose_functions(solution, calls)
    checks = [_check_table(number, check) for number, check in enumerate(draft.checks, 1)]
    tolerance = _propose_tolerance(solution, checks[0]["cas"], functions)
    for check in (each for each in checks if tolerance and "regarder" not in each):
        check.setdefault("tolerance", tolerance)
    declaration: dict[str, Any] = {
        "fonctions": functions,
        "solution": solution,
        "interdits": draft.forbidden.replace(",", " ").split(),
        "demandes": draft.required.replace(",", " ").split(),
        "erreurs": _mistake_tables(draft.mistakes),
        "verifications": checks,
    }
    proposed, drawn = _propose_draws(declaration, draft, trial)
    _share_remaining_points(checks)
    answers = _answers_or_none(declaration, trial)
    _drop_empty_lists(checks)
    signatures = proposals.propose_signatures(solution, functions)
    statement = _build_statement(draft, functions, answers)
    if checks[0]["titre"] == EXAMPLES_TITLE and not _shows_all_examples(statement, draft.checks[0], functions):
        checks[0]["titre"] = MORE_EXAMPLES_TITLE
    return CompletedExercise(
        title=draft.title.strip() or ", ".join(functions) or "Sans titre",
        summary=draft.summary.strip(),
        statement=statement,
        starter=_unix_newlines(draft.starter)
        if draft.starter.strip()
        else proposals.propose_starter(solution, functions),
        signatures=signatures,
        hints=tuple(_unix_newlines(hint).strip() for hint in draft.hints),
        declaration=declaration,
        draws=proposed.draws,
        call=proposed.call,
        conditions=proposed.conditions,
        drawn=tuple(drawn),
    )


def _unix_newlines(text: str) -> str:
    return text.replace("\r\n", "\n")


def _check_table(number: int, draft: CheckDraft) -> dict[str, Any]:
    """Return the table of a check, without the keys that the author leaves as they are."""
    check: dict[str, Any] = {
        "id": f"v{number}",
        "titre": draft.title.strip() or (EXAMPLES_TITLE if number == 1 else f"Vérification {number}"),
        "cas": [case.call.strip() for case in draft.nonempty_cases],
        "attendus": [case.expected.strip() for case in draft.nonempty_cases],
    }
    check |= {
        key: _unix_newlines(text).strip() for key, name in CHECK_TEXTS.items() if (text := getattr(draft, name)).strip()
    }
    check |= {
        key: _parse_number_or_text(text)
        for key, name in CHECK_NUMBERS.items()
        if (text := getattr(draft, name)).strip()
    }
    check |= {key: True for key, name in CHECK_FLAGS.items() if getattr(draft, name)}
    check |= {"espaces": False} if draft.ignores_spaces else {}
    check |= {key: choice for key, (name, usual) in CHECK_CHOICES.items() if (choice := getattr(draft, name)) != usual}
    conditions = [line.strip() for line in _unix_newlines(draft.conditions).split("\n") if line.strip()]
    check |= {"conditions": conditions} if conditions else {}
    check |= {"entrees": _unix_newlines(draft.lines).rstrip("\n").split("\n")} if draft.lines.strip() else {}
    check |= {"fichiers": _parse_file_texts(draft.files)} if draft.files.strip() else {}
    return check


def _parse_number_or_text(text: str) -> float | str:
    """Return the number that a text writes, in French or in Python; the text itself where it writes none."""
    try:
        return float(text.strip().replace(",", "."))
    except ValueError:
        return text.strip()


def _parse_file_texts(text: str) -> dict[str, str]:
    """Return the texts that stand below lines « === name »."""
    parts = FILE_LINE.split(_unix_newlines(text))
    return {name: body.removeprefix("\n") for name, body in zip(parts[1::2], parts[2::2], strict=True)}


def _mistake_tables(drafts: Sequence[MistakeDraft]) -> list[dict[str, str]]:
    named: dict[str, MistakeDraft] = {}
    for number, draft in enumerate(drafts, 1):
        identity = NOT_A_WORD.sub("_", unaccented(draft.title).lower()).strip("_")[:40] or f"erreur_{number}"
        named[identity if identity not in named else f"{identity}_{number}"] = draft
    return [
        {
            "id": identity,
            "titre": draft.title.strip(),
            "explication": _unix_newlines(draft.explanation).strip(),
            "question": _unix_newlines(draft.question).strip(),
            "programme": _unix_newlines(draft.program),
        }
        for identity, draft in named.items()
    ]


def _propose_tolerance(solution: str, cases: Sequence[str], functions: Sequence[str]) -> str:
    """Return the parameter within which the solution's answers are right, by the first check's cases; often empty."""
    try:
        imports = read_imports(solution)
        scenarios = [Scenario(parse_scenario(case, functions, imports=imports)) for case in cases]
        return propose_tolerance(solution, scenarios) if scenarios else ""
    except (MalformedDeclaration, SyntaxError, ValueError, RecursionError, MemoryError):
        return ""  # the trial says what is wrong


def _propose_draws(
    declaration: Mapping[str, Any], draft: ExerciseDraft, trial: ExerciseTrial
) -> tuple[ProposedDraws, list[tuple[str, str]]]:
    """Propose draws like the examples, where the author has written examples alone; return some of them, answered."""
    (first, *others), check = draft.checks, declaration["verifications"][0]
    is_plain = not (first.draws.strip() or first.lines.strip() or first.files.strip()) and first.watched == "valeur"
    if others or not is_plain or "points" in check:
        return ProposedDraws(), []
    imports = read_imports(declaration["solution"])
    proposed = proposals.propose_draws(check["cas"], declaration["fonctions"], imports)
    drawn = {
        **{key: check[key] for key in SHARED_KEYS if key in check},
        "id": "v2", "titre": DRAWN_TITLE, "tirages": proposed.draws, "appel": proposed.call,
        "conditions": list(proposed.conditions), "points": DRAWN_POINTS,
    }  # fmt: skip
    checks = [{**check, "points": MAX_POINTS - DRAWN_POINTS}, drawn]
    answered = trial.answer_draws({**declaration, "verifications": checks}) if proposed.draws else []
    return (proposed, answered[:SHOWN_DRAWS]) if answered else (ProposedDraws(), [])


def add_proposed_draws_check(draft: ExerciseDraft, completed: Mapping[str, Any]) -> ExerciseDraft:
    """Return the draft with a check of the draws that were proposed, compared as the examples are."""
    if not completed.get("draws"):
        return draft
    first = draft.checks[0]
    drawn = CheckDraft(
        title=DRAWN_TITLE, draws=completed["draws"], call=completed["call"], points=f"{DRAWN_POINTS:g}",
        conditions="\n".join(completed.get("conditions", ())), tolerance=first.tolerance, absolute=first.absolute,
        order=first.order, strict=first.strict,
    )  # fmt: skip
    return replace(draft, checks=(*draft.checks, drawn))


def _share_remaining_points(checks: list[dict[str, Any]]) -> None:
    """Give points to the checks for which the author says none: what the others leave of 20."""
    free = [check for check in checks if "points" not in check]
    taken = sum(check["points"] for check in checks if isinstance(check.get("points"), float))
    left = MAX_POINTS - taken
    for rank, check in enumerate(free):
        is_last = rank == len(free) - 1
        share = left if is_last else round(left / (len(free) - rank), 1)
        check["points"] = share
        left = round(left - share, 9)


def _answers_or_none(declaration: dict[str, Any], trial: ExerciseTrial) -> list[list[str]] | None:
    try:
        return trial.answer_written_cases(declaration)
    except MalformedDeclaration:
        return None


def _drop_empty_lists(checks: list[dict[str, Any]]) -> None:
    """Drop the keys of a check for which the author has written nothing."""
    for check in checks:
        if not any(check.get("attendus", ())):
            check.pop("attendus", None)
        if not check.get("cas"):
            check.pop("cas", None)


def _build_statement(draft: ExerciseDraft, functions: Sequence[str], answers: list[list[str]] | None) -> str:
    """Return the statement, with the first check's examples below where it shows no code."""
    is_program = is_whole_program(functions)
    named = "un programme" if is_program else ", ".join(f"`{name}`" for name in functions)
    text = _unix_newlines(draft.statement).strip() or f"Écrivez {named}."
    examples = draft.checks[0].nonempty_cases
    if "```" in text or answers is None or not examples:
        return text + "\n"
    if is_program:
        return text + "\n" + _format_example_runs(examples, answers[0])
    if draft.checks[0].watched != "valeur":
        return text + "\n"
    shown = [
        "\n".join([f">>> {line}" for line in _unix_newlines(case.call).strip().split("\n")] + [answer])
        for case, answer in zip(examples[:SHOWN_EXAMPLES], answers[0], strict=False)
        if answer and len(answer) <= MAX_SHOWN
    ]
    return f"{text}\n\n```python\n" + "\n".join(shown) + "\n```\n" if shown else text + "\n"


def _shows_all_examples(statement: str, check: CheckDraft, functions: Sequence[str]) -> bool:
    """Whether a statement has every example of a check, in the words in which it is written or told."""
    shown = "".join(statement.replace(">>>", "").split())
    try:
        texts = [_describe_call(case.call, functions) for case in check.nonempty_cases]
    except MalformedDeclaration:
        return True  # the trial says what is wrong
    return all("".join(text.split()) in shown for text in texts)


def _describe_call(call: str, functions: Sequence[str]) -> str:
    """Return what a statement shows of a call: of a whole program, what is typed."""
    return describe_case(Scenario(parse_scenario(call, [PROGRAM]))) if is_whole_program(functions) else call


def _format_example_runs(examples: Sequence[CaseDraft], printed: Sequence[str]) -> str:
    """Return what the program displays in the first examples, each below what is typed."""
    blocks = []
    for case, text in zip(examples[:SHOWN_EXAMPLES], printed, strict=False):
        words = describe_case(Scenario(parse_scenario(case.call, [PROGRAM])))
        if text[:1] in ("'", '"') and len(text) <= MAX_SHOWN:
            shown = str(evaluate_literal(text))
            blocks.append(f"\n{words}, le programme affiche :\n\n```text\n{shown.rstrip()}\n```\n")
    return "".join(blocks)
