"""What grades an exercise, as the course binds it: read now, or, of files that were found sound, when it is needed."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache, partial
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from graders.core.code.exercise import CodeDefinition
from graders.core.code.grading import CodeGrader
from graders.core.contract.definition import MODULE_FILE
from graders.core.contract.kits import SCENARIOS, find_available_kits
from graders.core.contract.malformed import MalformedExerciseError
from graders.core.contract.streams import stream
from graders.core.declared.exercise import DeclaredDefinition
from graders.core.declared.grading import DeclaredGrader
from server.course import toml_file
from server.course.closure import ImportGraph
from server.course.code import parse_python
from server.course.models import CourseFault, Problem
from server.course.schemas import ExerciseFile
from server.course.start_cache import ExerciseFacts
from server.course.version import compute_exercise_version, grader_folder
from server.text.markup import ModuleNames
from server.text.markup.text import no_module_names

if TYPE_CHECKING:
    from graders.core.answers import AnswersGrader
    from graders.core.contract.definition import Definition
    from graders.core.contract.protocol import Grader
    from graders.discovery import Discovery

NO_ANSWERS = "{}\n"
STARTER, SOLUTION = "starter.py", "solution.py"


def exercise_id_of_folder(path: Path) -> str:
    """The exercise of a folder of the course: "l20/poses"."""
    return f"{path.parents[1].name}/{path.name}"


@dataclass(frozen=True)
class ExerciseSources:
    """Where an exercise's parts are, what discovery found among the graders, what its texts may speak of.

    Of what is `known` already, no grader need be loaded.
    """

    curricula: tuple[Path, ...]
    code: tuple[Path, ...]
    discovery: Discovery | None
    imports: ImportGraph
    known: Mapping[str, ExerciseFacts] = field(default_factory=dict)
    names: Callable[[], ModuleNames] = no_module_names
    found: dict[str, ExerciseFacts] = field(default_factory=dict)

    def definition(self, path: Path) -> Definition | None:
        """What the grader's folder of an exercise defines, where it has one."""
        name = exercise_id_of_folder(path)
        if self.discovery is not None:
            return self.discovery.definitions.get(name)
        if not self.graders(path).is_dir():
            return None
        from graders.discovery import load_definition

        return load_definition(name)

    def graders(self, path: Path) -> Path:
        """The folder of what grades the exercise of this folder of the course."""
        return grader_folder(self.code, path.parents[1].name, path.name)


class GradedExercise(NamedTuple):
    """What depends on the kind of an exercise. `make` gives its grader; it loads it the first time."""

    starter: str
    solution: str
    make: Callable[[], Grader]
    found: ExerciseFacts


def read_graded_exercise(sources: ExerciseSources, path: Path, card: ExerciseFile) -> GradedExercise:
    """Raises CourseFault, where it is not known that it is sound."""
    name = exercise_id_of_folder(path)
    known = sources.known.get(name)
    make = cache(partial(_load_grader, sources, path, card))
    starter, solution = (NO_ANSWERS, "") if known is None else _read_starter_and_solution(sources, path, card)
    if known is None:
        grader = make()
        if isinstance(grader, CodeGrader | DeclaredGrader):
            starter = read_python_that_compiles(path / STARTER)
            solution = _require_compilable(grader.solution, sources.graders(path) / SOLUTION)
        known = _exercise_facts(sources, path, card, grader)
    sources.found[name] = known
    return GradedExercise(starter, solution, make, known)


def _read_starter_and_solution(sources: ExerciseSources, path: Path, card: ExerciseFile) -> tuple[str, str]:
    """Starter and solution, which compile."""
    if card.kind == "answers":
        return NO_ANSWERS, ""
    return toml_file.read_text(path / STARTER), toml_file.read_text(sources.graders(path) / SOLUTION)


def _exercise_facts(sources: ExerciseSources, path: Path, card: ExerciseFile, grader: Grader) -> ExerciseFacts:
    kit = _find_kit_name(path, grader) if isinstance(grader, CodeGrader) else ""
    kit = SCENARIOS if isinstance(grader, DeclaredGrader) else kit
    ticked = _choice_question_ids(grader) if card.kind == "answers" else ()
    promises = _promises_by_function(grader) if isinstance(grader, CodeGrader) else {}
    return ExerciseFacts(
        compute_exercise_version(sources.imports, sources.code, path, card, grader, kit), kit, ticked, promises
    )


def _promises_by_function(grader: CodeGrader) -> dict[str, tuple[tuple[str, str], ...]]:
    """Return what the contracts of the functions promise, in French."""
    return {
        contract.function: tuple((line.label, line.text) for line in contract.promise_lines())
        for contract in grader.contracts
    }


def _choice_question_ids(grader: Grader) -> tuple[str, ...]:
    from graders.core.answers.choice import ChoiceGrader

    return tuple(question.id for question in grader.questions) if isinstance(grader, ChoiceGrader) else ()


def _load_grader(sources: ExerciseSources, path: Path, card: ExerciseFile) -> Grader:
    makers: Mapping[str, Callable[[ExerciseSources, Path, ExerciseFile], Grader]]
    makers = {"code": _load_code_grader, "answers": _load_answers_grader}
    return makers[card.kind](sources, path, card)


def _load_code_grader(sources: ExerciseSources, path: Path, card: ExerciseFile) -> CodeGrader | DeclaredGrader:
    definition = sources.definition(path)
    if definition is None:
        raise CourseFault(_missing_grader_problem(sources, path))
    if not isinstance(definition, CodeDefinition | DeclaredDefinition):
        raise CourseFault(_wrong_kind_problem(path, card))
    if not card.functions:
        raise CourseFault(Problem(path / "exercise.toml", 1, "champ manquant : « functions »"))
    _check_functions_match(path / "exercise.toml", card, definition.judged_functions)
    try:
        return definition.bind([function.name for function in card.functions])
    except MalformedExerciseError as error:
        raise CourseFault(Problem(error.path, error.line, error.message)) from error


def _find_kit_name(path: Path, grader: CodeGrader) -> str:
    kit = grader.kit(stream(0, "kit")).module
    if kit not in find_available_kits(path.parents[1]):
        raise CourseFault(Problem(grader.folder / MODULE_FILE, None, f"trousse inconnue : « {kit} »"))
    return kit


def _load_answers_grader(sources: ExerciseSources, path: Path, card: ExerciseFile) -> AnswersGrader:
    from server.course import questions

    definition = sources.definition(path)
    if isinstance(definition, CodeDefinition | DeclaredDefinition):
        raise CourseFault(_wrong_kind_problem(path, card))
    if card.functions:
        raise CourseFault(Problem(path / "exercise.toml", None, "un exercice sans code ne demande aucune fonction"))
    sheet = questions.read_questions(path / questions.FILE)
    if sheet.needs_grader and definition is None:
        raise CourseFault(_missing_grader_problem(sources, path))
    return sheet.build_grader(exercise_id_of_folder(path), definition)


def _wrong_kind_problem(path: Path, card: ExerciseFile) -> Problem:
    message = f'kind = "{card.kind}", mais le correcteur est celui d’un exercice de l’autre sorte'
    return Problem(path / "exercise.toml", None, message)


def _missing_grader_problem(sources: ExerciseSources, path: Path) -> Problem:
    folder = sources.graders(path)
    told = sources.discovery.problems if sources.discovery is not None else ()
    cause = next((problem for problem in told if problem.path.is_relative_to(folder)), None)
    why = f" : {cause.path}:{cause.line}: {cause.message}" if cause else ""
    return Problem(path / "exercise.toml", None, f"exercice sans correcteur utilisable{why}")


def _check_functions_match(path: Path, card: ExerciseFile, judged: frozenset[str]) -> None:
    announced = [function.name for function in card.functions]
    for name in sorted(judged ^ set(announced)):
        where = "annoncée mais non corrigée" if name in announced else "corrigée mais non annoncée"
        raise CourseFault(Problem(path, None, f"fonction {where} : « {name} »"))


def read_python_that_compiles(path: Path) -> str:
    """The text of a Python file. Raises CourseFault where it does not compile."""
    return _require_compilable(toml_file.read_text(path), path)


def _require_compilable(source: str, path: Path) -> str:
    parse_python(source, path)
    return source
