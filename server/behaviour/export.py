"""A group that a teacher has named, as a misconception for the authors of the course: see `graders/core/README.md`.

The archive holds what is to be added to the exercise's `misconceptions.toml`, and `misconceptions/<id>.py`: the
shortest program of the group, without comments, texts and whatever else tells who wrote it.
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
from server.base.errors import Invalid
from server.behaviour.models import BehaviourGroup
from server.behaviour.schemas import GroupDescription
from server.course.models import Exercise

LONGEST_ID = 40
CREDITS = frozenset({f"__{one}__" for one in ("author", "authors", "contact", "copyright", "credits", "email")})
UNREAD = """\
RELU = False  # Programme d’élève, qui sera exécuté sans bac à sable : relisez-le, puis écrivez True.
if RELU:
"""
UNREADABLE = "Ce programme ne se relit pas sans ses commentaires : il ne peut pas être exporté."


def render_archive(
    exercise: Exercise, group: BehaviourGroup, words: GroupDescription, source: bytes, names: Collection[str] = ()
) -> tuple[str, bytes]:
    """The misconception's id, and the archive; `names` are its author's. Raises Invalid for a program that cannot be
    rewritten."""
    identity = misconception_id(words.title, exercise.grader.mistakes() | SLIPS.keys())
    wrong = [one.name for one in exercise.functions if one.name in group.functions]
    functions = wrong or [one.name for one in exercise.functions]
    held = io.BytesIO()
    with zipfile.ZipFile(held, "w", zipfile.ZIP_DEFLATED) as archived:
        archived.writestr(MISCONCEPTIONS, catalogue_entry(exercise.id, identity, functions, words))
        archived.writestr(f"misconceptions/{identity}.py", guard_unread_program(anonymise_program(source, names)))
    return identity, held.getvalue()


def misconception_id(title: str, taken: Collection[str]) -> str:
    """A name for files and tables, from a title: "La rotation est oubliée" is la_rotation_est_oubliee."""
    letters = unicodedata.normalize("NFKD", title).encode("ascii", "ignore").decode().lower()
    name = "_".join(re.findall("[a-z0-9]+", letters))[:LONGEST_ID].strip("_") or "erreur"
    name = name if name[0].isalpha() else f"erreur_{name}"
    places = (name, *(f"{name}_{number}" for number in range(2, len(taken) + 3)))
    return next(one for one in places if one not in taken)


def catalogue_entry(exercise_id: str, identity: str, functions: Collection[str], words: GroupDescription) -> str:
    """What is to be added to the catalogue. A JSON text is a TOML one where no DEL is in it."""
    members = {
        "id": identity,
        "functions": list(functions),
        "title": words.title,
        "explanation": words.explanation,
        "question": words.question,
    }
    lines = [f"{name} = {json.dumps(value, ensure_ascii=False)}" for name, value in members.items()]
    return "\n".join([f"# À ajouter à graders/{exercise_id}/{MISCONCEPTIONS}", "[[misconception]]", *lines, ""])


def guard_unread_program(program: str) -> str:
    """A program that does nothing, until who writes the course has read it and says so in its first line.

    Misconceptions are run where verdicts are made, without walls: what a student has written must not be, unread.
    """
    return UNREAD + textwrap.indent(program or "pass\n", "    ")


def anonymise_program(source: bytes, names: Collection[str] = ()) -> str:
    """The program without comments, loose texts, who wrote it, future imports, and what only runs by itself; in the
    texts that it needs, these names are replaced.

    Raises Invalid.
    """
    try:
        tree = _Bare(names).visit(ast.parse(source))
        return ast.unparse(ast.fix_missing_locations(tree)) + "\n"
    except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
        raise Invalid(UNREADABLE) from error


class _Bare(ast.NodeTransformer):
    """Takes out what a program does not need."""

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
        alone = any(isinstance(one, ast.Name) and one.id == "__name__" for one in ast.walk(node.test))
        return None if alone else self.generic_visit(node)

    def visit_Constant(self, node: ast.Constant) -> ast.AST:
        if isinstance(node.value, str) and self._names is not None:
            return ast.Constant(self._names.sub("élève", node.value))
        return node

    def generic_visit(self, node: ast.AST) -> ast.AST:
        """A block of which everything was taken out does nothing."""
        visited = super().generic_visit(node)
        if getattr(visited, "body", None) == [] and not isinstance(visited, ast.Module):
            setattr(visited, "body", [ast.Pass()])  # noqa: B010
        return visited
