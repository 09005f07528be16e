"""Writing of imported drafts as folders of declared exercises."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

from graders.core.declared.declaration import is_whole_program
from graders.core.declared.proposals import WHOLE_PROGRAM, propose_starter
from graders.core.syntax_trees import parse_source
from server.authoring.new import write_skeleton
from server.course.toml_writing import write_toml_table, write_toml_value
from server.studio.import_drafts import NO_SOLUTION, ImportDraft

DECLARED = "declared"


def write_drafts(drafts: list[ImportDraft], name: str, course: Path) -> Iterator[tuple[ImportDraft, list[Path]]]:
    """Write each draft that has cases, the second one as « name_2 »; yield it with its files.

    Raises SkeletonRefused, having written nothing of it.
    """
    usable = [draft for draft in drafts if draft.checks]
    for number, draft in enumerate(usable, 1):
        yield draft, _write_draft_files(draft, name if number == 1 else f"{name}_{number}", course)
    for draft in drafts:
        if not draft.checks:
            yield draft, []


def _write_draft_files(draft: ImportDraft, name: str, course: Path) -> list[Path]:
    files = write_skeleton(DECLARED, name, course)
    by_name = {path.name: path for path in files}
    card = by_name["exercise.toml"].read_text(encoding="utf-8")
    order = next(line for line in card.splitlines() if line.startswith("order"))
    texts = {
        "exercise.toml": _build_exercise_toml(draft, order),
        "enonce.md": draft.statement or f"Écrivez {', '.join(f'`{name}`' for name in draft.functions)}.\n",
        "starter.py": _build_starter(draft),
        "solution.py": draft.solution or NO_SOLUTION,
        "declaration.toml": "".join(write_toml_table(draft.build_declaration())),
    }
    for file, text in texts.items():
        by_name[file].write_text(text.rstrip("\n") + "\n", encoding="utf-8")
    by_name["autrement.py"].unlink()  # the skeleton's own specimen
    return [path for path in files if path.exists()]


def _build_starter(draft: ImportDraft) -> str:
    if is_whole_program(draft.functions):
        return propose_starter("", draft.functions)
    return "".join(
        f"{_function_header(draft, name)}\n    # À vous de jouer.\n    pass\n\n\n" for name in draft.functions
    )


def _build_exercise_toml(draft: ImportDraft, order: str) -> str:
    lines = [f"title = {write_toml_value(draft.title)}", f"summary = {write_toml_value(draft.title)}", order]
    for name in draft.functions:
        signature = _function_header(draft, name).removeprefix("def ").rstrip(":")
        if is_whole_program(draft.functions):
            signature = WHOLE_PROGRAM
        lines += ["", "[[functions]]", f"name = {write_toml_value(name)}", f"signature = {write_toml_value(signature)}"]
    return "\n".join(lines)


def _function_header(draft: ImportDraft, name: str) -> str:
    """Return the line that defines a function: the solution's, else one with as many parameters as its calls have."""
    nodes = parse_source(draft.solution).body if draft.solution else []
    for node in nodes:
        if isinstance(node, ast.FunctionDef) and node.name == name:
            return f"def {name}({ast.unparse(node.args)}):"
        if isinstance(node, ast.ClassDef) and node.name == name:
            return f"class {name}:"
    calls = (parse_source(case).body[-1] for check in draft.checks for case in check["cas"])
    own = (node.value for node in calls if isinstance(node, ast.Expr) and isinstance(node.value, ast.Call))
    counts = [len(call.args) for call in own if isinstance(call.func, ast.Name) and call.func.id == name]
    return f"def {name}({', '.join(f'x{k}' for k in range(1, max(counts, default=0) + 1))}):"
