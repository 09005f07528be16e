"""Export a named group as a misconception for the authors of the course: see `graders/core/README.md`.

The archive holds an entry to be added to the exercise's `misconceptions.toml`, and `misconceptions/<id>.py`: the
shortest program of the group, anonymised.
"""

import ast
import io
import json
import re
import textwrap
import unicodedata
import zipfile
from collections.abc import Collection

from graders.core.code.folder import MISCONCEPTIONS
from graders.core.compare.slips import SLIPS
from graders.core.syntax_trees import parse_source
from server.base.errors import Invalid
from server.behaviour.models import BehaviourGroup
from server.behaviour.schemas import GroupDescription
from server.course.models import Exercise

MAX_ID_LENGTH = 40
CREDITS = frozenset({f"__{name}__" for name in ("author", "authors", "contact", "copyright", "credits", "email")})
UNREAD_GUARD = """\
RELU = False  # Programme d’élève, qui sera exécuté sans bac à sable : relisez-le, puis écrivez True.
if RELU:
"""
UNREADABLE = "Ce programme ne se relit pas sans ses commentaires : il ne peut pas être exporté."


def build_misconception_archive(
    exercise: Exercise, group: BehaviourGroup, description: GroupDescription, source: bytes, names: Collection[str] = ()
) -> tuple[str, bytes]:
    """Return the misconception's id, and the archive; `names` are the author's. Raise Invalid for a program that cannot
    be rewritten."""
    identity = make_misconception_id(description.title, exercise.grader.mistake_ids() | SLIPS.keys())
    wrong = [function.name for function in exercise.functions if function.name in group.functions]
    functions = wrong or [function.name for function in exercise.functions]
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr(MISCONCEPTIONS, format_catalogue_entry(exercise.id, identity, functions, description))
        archive.writestr(f"misconceptions/{identity}.py", add_unread_guard(anonymise_program(source, names)))
    return identity, content.getvalue()


def make_misconception_id(title: str, taken: Collection[str]) -> str:
    """Return an unused id made of a title: "La rotation est oubliée" gives la_rotation_est_oubliee."""
    letters = unicodedata.normalize("NFKD", title).encode("ascii", "ignore").decode().lower()
    name = "_".join(re.findall("[a-z0-9]+", letters))[:MAX_ID_LENGTH].strip("_") or "erreur"
    name = name if name[0].isalpha() else f"erreur_{name}"
    candidates = (name, *(f"{name}_{number}" for number in range(2, len(taken) + 3)))
    return next(candidate for candidate in candidates if candidate not in taken)


def format_catalogue_entry(
    exercise_id: str, identity: str, functions: Collection[str], description: GroupDescription
) -> str:
    """Return the entry for the catalogue, in TOML: JSON strings without DEL are TOML strings."""
    members = {
        "id": identity,
        "functions": list(functions),
        "title": description.title,
        "explanation": description.explanation,
        "question": description.question,
    }
    lines = [f"{name} = {json.dumps(value, ensure_ascii=False)}" for name, value in members.items()]
    return "\n".join([f"# À ajouter à graders/{exercise_id}/{MISCONCEPTIONS}", "[[misconception]]", *lines, ""])


def add_unread_guard(program: str) -> str:
    """Return a program that does nothing until an author of the course has read it, and says so in its first line.

    Misconceptions run without a sandbox, in the grading process: a student's program must not run there unread.
    """
    return UNREAD_GUARD + textwrap.indent(program or "pass\n", "    ")


def anonymise_program(source: bytes, names: Collection[str] = ()) -> str:
    """Return the program without comments, loose strings, credits, future imports and main blocks; these names are
    replaced in its other strings. Raise Invalid.
    """
    try:
        tree = _Anonymiser(names).visit(parse_source(source))
        return ast.unparse(ast.fix_missing_locations(tree)) + "\n"
    except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
        raise Invalid(UNREADABLE) from error


class _Anonymiser(ast.NodeTransformer):
    """Removes the parts that a program does not need."""

    def __init__(self, names: Collection[str]) -> None:
        words = sorted((re.escape(name) for name in names if len(name) > 2), key=len, reverse=True)
        alone = rf"(?<![^\W_])({'|'.join(words)})(?![^\W_])"  # "ada_lovelace" is two words
        self._names = re.compile(alone, re.IGNORECASE) if words else None

    def visit_Expr(self, node: ast.Expr) -> ast.AST | None:
        return None if isinstance(node.value, ast.Constant) else self.generic_visit(node)

    def visit_ImportFrom(self, node: ast.ImportFrom) -> ast.AST | None:
        return None if node.module == "__future__" else node

    def visit_Assign(self, node: ast.Assign) -> ast.AST | None:
        names = {target.id if isinstance(target, ast.Name) else "" for target in node.targets}
        return None if names <= CREDITS else self.generic_visit(node)

    def visit_AnnAssign(self, node: ast.AnnAssign) -> ast.AST | None:
        return None if isinstance(node.target, ast.Name) and node.target.id in CREDITS else self.generic_visit(node)

    def visit_If(self, node: ast.If) -> ast.AST | None:
        alone = any(isinstance(child, ast.Name) and child.id == "__name__" for child in ast.walk(node.test))
        return None if alone else self.generic_visit(node)

    def visit_Constant(self, node: ast.Constant) -> ast.AST:
        if isinstance(node.value, str) and self._names is not None:
            return ast.Constant(self._names.sub("élève", node.value))
        return node

    def generic_visit(self, node: ast.AST) -> ast.AST:
        """Put `pass` into a block that has become empty."""
        visited = super().generic_visit(node)
        if getattr(visited, "body", None) == [] and not isinstance(visited, ast.Module):
            setattr(visited, "body", [ast.Pass()])  # noqa: B010
        return visited
