"""A verdict for the terminal. Works on the verdict's JSON, whether it comes from here or from a server."""

import textwrap
from collections.abc import Iterator
from typing import Any

Json = dict[str, Any]
WIDTH = 100
SPACES = " \t\u00a0\u202f"
FULL_MARKS, NOT_FULL, CANNOT = 0, 1, 2

OUTCOMES = {
    "ok": "réussi",
    "wrong_answer": "réponse fausse",
    "syntax_error": "erreur de syntaxe",
    "import_error": "import impossible",
    "missing_function": "fonction manquante",
    "runtime_error": "erreur à l’exécution",
    "timeout": "temps dépassé",
    "memory_limit": "mémoire dépassée",
    "output_limit": "réponse trop volumineuse",
    "forbidden_operation": "opération interdite",
    "invalid_output": "réponse illisible",
    "internal_error": "erreur de notre côté",
}


def exit_status(verdict: Json) -> int:
    if verdict["outcome"] == "internal_error":
        return CANNOT
    return FULL_MARKS if verdict["outcome"] == "ok" else NOT_FULL


def render(verdict: Json) -> str:
    """The whole verdict in French, ready to print."""
    return "\n".join(_lines(verdict))


def _lines(verdict: Json) -> Iterator[str]:
    outcome = OUTCOMES.get(verdict["outcome"], verdict["outcome"])
    if verdict["outcome"] == "internal_error":
        yield f"{verdict['exercise']} : la correction a échoué de notre côté ; rien n’est compté."
        yield "Vous pouvez renvoyer le fichier tel quel."
    else:
        yield f"{verdict['exercise']} : {number(verdict['points'])}/{number(verdict['max_points'])} — {outcome}"
    yield ""
    repeated: set[str] = set()
    for check in verdict["checks"]:
        yield from _check(check, repeated)
    yield from _diagnosis(verdict["diagnosis"])
    yield from _stdout(verdict["stdout"])
    yield f"Graine : {verdict['seed']} (pour refaire cette correction : --seed {verdict['seed']})"


def _check(check: Json, repeated: set[str]) -> Iterator[str]:
    mark = "✓" if check["passed"] else "✗"
    yield f"  {mark} {check['title']}  ({number(check['points'])}/{number(check['max_points'])})"
    if check["passed"]:
        return
    if check["message"] in repeated:  # a file that does not load fails every check for one reason
        return
    repeated.add(check["message"])
    yield from paragraph(check["message"])
    if check["counterexample"]:
        yield from _counterexample(check["counterexample"])
    if check["hint"]:
        yield from paragraph(f"→ {check['hint']}")


def _counterexample(example: Json) -> Iterator[str]:
    for name, value in example["inputs"].items():
        yield from _value(name, value)
    yield from _value("attendu", example["expected"])
    yield from _value("obtenu", example["got"])


def _value(name: str, value: Any) -> Iterator[str]:
    yield from paragraph(f"{name} : {value if isinstance(value, str) else _compact(value)}", indent=10)


def _compact(value: Any) -> str:
    """French numbers, as in the messages; `--json` has all their digits."""
    from graders.core.compare.words import text

    return text(value)


def _diagnosis(diagnosis: Json | None) -> Iterator[str]:
    if diagnosis:
        yield ""
        yield f"Diagnostic : {diagnosis['title']}"
        yield from paragraph(diagnosis["explanation"], indent=2)
        yield ""


def _stdout(text: str) -> Iterator[str]:
    if text.strip():
        yield "Affiché par le programme :"
        yield from (f"  │ {printable(line)}" for line in text.rstrip("\n").splitlines())


def paragraph(text: str, indent: int = 6) -> Iterator[str]:
    margin = " " * indent
    for line in printable(text, keep="\n").splitlines():
        yield from textwrap.wrap(line, WIDTH, initial_indent=margin, subsequent_indent=margin) or [""]


def printable(text: str, keep: str = "") -> str:
    """What a student's program wrote may not drive the reader's terminal: control characters are shown as ·."""
    return "".join(c if c.isprintable() or c in keep + SPACES else "·" for c in text)


def number(value: float) -> str:
    """17.5 → « 17,5 »; 17.0 → « 17 »."""
    return f"{value:.2f}".rstrip("0").rstrip(".").replace(".", ",")
