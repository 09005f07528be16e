"""Discovery of the course: what is well formed is served, what is not is reported with its place."""

from __future__ import annotations

import ast
import re
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from enum import Enum
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, TypeVar

from graders.core.answers.choice import ChoiceGrader
from graders.core.code.exercise import CodeDefinition
from graders.core.contract.kits import kits_of
from graders.core.contract.malformed import MalformedExerciseError
from graders.core.contract.streams import stream
from server.course import drawings, questions, reuse, toml_file
from server.course.closure import Imports
from server.course.library import Library, problems_of
from server.course.memory import Memory, source_of
from server.course.models import Course, CourseFault, Exercise, FunctionSpec, Module, Problem, ReadingPath
from server.course.schemas import ExerciseFile, ModuleFile
from server.course.toml_places import line_of
from server.course.version import version
from server.text.markup import Names, Source, Text
from server.text.markup.text import no_names

if TYPE_CHECKING:
    from graders.core.contract.definition import Definition
    from graders.discovery import Discovery

T = TypeVar("T")
ROOT = Path(__file__).parents[2]
MODULE_SLUG = re.compile(r"[a-z]+[0-9]+")  # addresses start with it, beside /connexion and its like
EXERCISE_SLUG = re.compile(r"[a-z0-9]+(_[a-z0-9]+)*")
NOTHING_ANSWERED = "{}\n"
HINT_TITLE = re.compile(r"^##[ \t]+Indice[ \t]+(\d+)[ \t]*$", re.MULTILINE)


@dataclass(frozen=True)
class Sources:
    """Where an exercise's parts are, what discovery found among the graders, what its texts may speak of."""

    curriculum: Path
    code: Path
    discovery: Discovery
    imports: Imports
    names: Callable[[], Names] = no_names


class Look(Enum):
    """How closely the texts are looked at while the course is loaded."""

    no = "they are read when they are asked for"
    read = "what they say of each other is followed, but no formula is drawn"
    drawn = "all of it"


def load(
    curriculum: Path = ROOT / "curriculum",
    *,
    code: Path = ROOT,
    discovery: Discovery | None = None,
    render: bool = True,
    check: bool = False,
    memory: Memory | None = None,
) -> Course:
    """Read the whole course. Never raises for a malformed module or exercise: see `Course.problems`.

    `code` holds `graders/` and `reference/`, which versions cover. Rendering all the texts takes seconds, most of it
    for the formulas. With `render=False` a text is rendered when it is looked at, and its faults are not looked for;
    with `check=True` too, all of its faults are, but for those of formulas: once, where `memory` says that these very
    files were sound.
    """
    memory = memory or Memory()
    look = Look.drawn if render else Look.read if check else Look.no
    source = source_of(curriculum, code) if look is Look.read else ""
    if source and memory.is_sound(source):
        look = Look.no
    if discovery is None:
        from graders.discovery import discover

        discovery = discover()
    problems = [Problem(problem.path, problem.line, problem.message) for problem in discovery.problems]
    sources = Sources(curriculum, code, discovery, Imports(code, memory))
    modules = _each(problems, lambda path: _module(sources, path, problems, look), _modules(curriculum))
    modules.sort(key=lambda module: (module.order, module.slug))
    problems.extend(_orphans(sources))
    if source:
        memory.keep("" if problems else source)
    return Course(MappingProxyType({module.slug: module for module in modules}), tuple(problems))


def _each(problems: list[Problem], build: Callable[[Path], T], paths: list[Path]) -> list[T]:
    """What `build` makes of each path; where it cannot, its problem is noted and the others go on."""
    built = []
    for path in paths:
        try:
            built.append(build(path))
        except CourseFault as fault:
            problems.append(fault.problem)
    return built


def _modules(curriculum: Path) -> list[Path]:
    return sorted(path for path in curriculum.iterdir() if path.is_dir() and not path.name.startswith((".", "__")))


def _exercises(module: Path) -> list[Path]:
    folder = module / "exercices"
    return sorted(path for path in folder.iterdir() if path.is_dir()) if folder.is_dir() else []


def _module(sources: Sources, path: Path, problems: list[Problem], look: Look) -> Module:
    if not MODULE_SLUG.fullmatch(path.name):
        raise CourseFault(Problem(path, None, "nom de module : des minuscules puis un nombre, comme « l20 »"))
    card = toml_file.read(path / "module.toml", ModuleFile)
    kits = {name: {place: _python(file) for place, file in files.items()} for name, files in kits_of(path).items()}
    library = Library(path, drawings.read(path / "figures", problems), problems)
    sources = replace(sources, names=library.names)
    exercises = _each(problems, lambda folder: _exercise(sources, path, folder), _exercises(path))
    exercises = reuse.closed(path / "exercices", exercises, problems)
    exercises.sort(key=lambda exercise: (exercise.stars, exercise.order, exercise.slug))
    library.exercises.update({exercise.slug: exercise.title for exercise in exercises})
    library.questions.update(_ticked(exercises))
    if look is not Look.no:
        exercises = [exercise for exercise in exercises if not _note(problems, _faults(exercise, look))]
        _note(problems, library.check(formulas=look is Look.drawn))
        _note(problems, _lost(path, exercises, library))
        _note(problems, _of_card(path / "module.toml", card, library, formulas=look is Look.drawn))
    return Module(
        slug=path.name,
        title=card.title,
        number=card.number,
        summary=card.summary,
        track=card.track,
        sessions=card.sessions,
        prerequisites=tuple(card.prerequisites),
        objectives=tuple(card.objectives),
        references=tuple(card.references),
        previous=card.previous,
        next=card.next,
        order=card.order,
        kits=MappingProxyType(kits),
        exercises=tuple(exercises),
        lessons=library.lessons,
        glossary=MappingProxyType(library.glossary),
        drawings=MappingProxyType(library.drawings),
        files=MappingProxyType(library.files),
        paths=tuple(ReadingPath(one.title, one.summary, one.page) for one in card.paths),
        names=library.names,
    )


def _note(problems: list[Problem], new: Iterable[Problem]) -> bool:
    """True where there were some."""
    before = len(problems)
    problems.extend(new)
    return len(problems) > before


def _faults(exercise: Exercise, look: Look) -> Iterator[Problem]:
    for text in (exercise.statement, *exercise.hint_texts):
        yield from problems_of(text, formulas=look is Look.drawn)
    if exercise.answers is not None:
        path = exercise.statement.source.path.with_name(questions.FILE)
        yield from questions.problems(path, exercise.answers, exercise.names, formulas=look is Look.drawn)


def _ticked(exercises: list[Exercise]) -> Iterator[str]:
    """The questions that a lesson may ask: those of which one ticks the options."""
    for exercise in exercises:
        if isinstance(exercise.answers, ChoiceGrader):
            yield from (f"{exercise.slug}/{question.id}" for question in exercise.answers.questions)


def _lost(module: Path, exercises: list[Exercise], library: Library) -> Iterator[Problem]:
    """Exercises that are said to follow a lesson that does not exist."""
    lessons = {lesson.slug for lesson in library.lessons}
    for exercise in exercises:
        if exercise.seance and exercise.seance not in lessons:
            path = module / "exercices" / exercise.slug / "exercise.toml"
            line = line_of(toml_file.read_text(path), ("seance",))
            yield Problem(path, line, f"« seance » : page inconnue « {exercise.seance} »")


def _of_card(path: Path, card: ModuleFile, library: Library, *, formulas: bool) -> Iterator[Problem]:
    """Its paths and its references, each of which may lead somewhere."""
    source = toml_file.read_text(path)
    for number, one in enumerate(card.paths):
        if library.names().pages.get(one.page.partition("#")[0]) is None:
            message = f"« page » : page inconnue « {one.page} »"
            yield Problem(path, line_of(source, ("paths", number, "page")), message)
    for number, reference in enumerate(card.references):
        line = line_of(source, ("references", number))
        yield from problems_of(Text(Source(reference, path, line or 1, names=library.names)), formulas=formulas)


def _exercise(sources: Sources, module: Path, path: Path) -> Exercise:
    if not EXERCISE_SLUG.fullmatch(path.name):
        raise CourseFault(Problem(path, None, "nom d’exercice : minuscules, chiffres et « _ »"))
    card = toml_file.read(path / "exercise.toml", ExerciseFile)
    kinds = {"code": _code, "answers": _answers}
    graded = kinds[card.kind](sources, path, card)
    return Exercise(
        module=module.name,
        slug=path.name,
        title=card.title,
        summary=card.summary,
        order=card.order,
        stars=card.stars,
        origin=card.origin,
        functions=tuple(
            FunctionSpec(function.name, function.signature, function.returns, function.doc, tuple(function.parts))
            for function in card.functions
        ),
        **graded,
        statement=Text(Source(toml_file.read_text(path / "enonce.md"), path / "enonce.md", names=sources.names)),
        hint_texts=_hints(path / "indices.md", sources.names),
        names=sources.names,
        version=version(sources.imports, sources.code, path, card, graded["grader"], graded.get("kit", "")),
        seance=card.seance,
        policy=card.limits.policy(),
        reuses=tuple(card.reuses),
    )


def _definition(sources: Sources, path: Path) -> Definition | None:
    """What the grader's folder of an exercise defines, where it has one."""
    return sources.discovery.definitions.get(f"{path.parents[1].name}/{path.name}")


def _code(sources: Sources, path: Path, card: ExerciseFile) -> dict[str, Any]:
    definition = _definition(sources, path)
    if definition is None:
        raise CourseFault(_no_grader(sources, path))
    if not isinstance(definition, CodeDefinition):
        raise CourseFault(_other_kind(path, card))
    if not card.functions:
        raise CourseFault(Problem(path / "exercise.toml", 1, "champ manquant : « functions »"))
    _same_functions(path / "exercise.toml", card, definition.judged)
    try:
        grader = definition.bind([function.name for function in card.functions])
    except MalformedExerciseError as error:
        raise CourseFault(Problem(error.path, error.line, error.message)) from error
    kit = grader.kit(stream(0, "kit")).module
    if kit not in kits_of(path.parents[1]):
        raise CourseFault(Problem(definition.folder / "grader.py", None, f"trousse inconnue : « {kit} »"))
    return {
        "kit": kit,
        "starter": _python(path / "starter.py"),
        "solution": _compiles(grader.solution, definition.folder / "solution.py"),
        "grader": grader,
    }


def _answers(sources: Sources, path: Path, card: ExerciseFile) -> dict[str, Any]:
    definition = _definition(sources, path)
    if isinstance(definition, CodeDefinition):
        raise CourseFault(_other_kind(path, card))
    if card.functions:
        raise CourseFault(Problem(path / "exercise.toml", None, "un exercice sans code ne demande aucune fonction"))
    sheet = questions.read(path / questions.FILE)
    if sheet.needs_grader and definition is None:
        raise CourseFault(_no_grader(sources, path))
    grader = sheet.bind(f"{path.parents[1].name}/{path.name}", definition)
    return {"starter": NOTHING_ANSWERED, "solution": "", "grader": grader, "answers": grader}


def _other_kind(path: Path, card: ExerciseFile) -> Problem:
    message = f'kind = "{card.kind}", mais le correcteur est celui d’un exercice de l’autre sorte'
    return Problem(path / "exercise.toml", None, message)


def _no_grader(sources: Sources, path: Path) -> Problem:
    folder = sources.code / "graders" / path.parents[1].name / path.name
    cause = next((problem for problem in sources.discovery.problems if problem.path.is_relative_to(folder)), None)
    why = f" : {cause.path}:{cause.line}: {cause.message}" if cause else ""
    return Problem(path / "exercise.toml", None, f"exercice sans correcteur utilisable{why}")


def _same_functions(path: Path, card: ExerciseFile, judged: frozenset[str]) -> None:
    announced = [function.name for function in card.functions]
    for name in sorted(judged ^ set(announced)):
        where = "annoncée mais non corrigée" if name in announced else "corrigée mais non annoncée"
        raise CourseFault(Problem(path, None, f"fonction {where} : « {name} »"))


def _python(path: Path) -> str:
    return _compiles(toml_file.read_text(path), path)


def _compiles(source: str, path: Path) -> str:
    try:
        ast.parse(source)
    except (SyntaxError, ValueError) as error:
        line = error.lineno if isinstance(error, SyntaxError) else None
        raise CourseFault(Problem(path, line, f"ce fichier Python ne se compile pas ({error})")) from error
    return source


def _hints(path: Path, names: Callable[[], Names]) -> tuple[Text, Text, Text]:
    text = toml_file.read_text(path)
    titles = list(HINT_TITLE.finditer(text))
    if [title[1] for title in titles] != ["1", "2", "3"]:
        line = text[: titles[-1].start()].count("\n") + 1 if titles else 1
        raise CourseFault(Problem(path, line, "il faut trois parties : « ## Indice 1 », « 2 » puis « 3 »"))
    ends = [*(title.start() for title in titles[1:]), len(text)]
    first, second, third = (_part(path, text, title.end(), end, names) for title, end in zip(titles, ends, strict=True))
    return first, second, third


def _part(path: Path, text: str, start: int, end: int, names: Callable[[], Names]) -> Text:
    line = text[:start].count("\n") + 1
    if not text[start:end].strip():
        raise CourseFault(Problem(path, line, "indice vide"))
    return Text(Source(text[start:end], path, line, names=names))


def _orphans(sources: Sources) -> Iterator[Problem]:
    """Graders without an exercise: a renamed folder must not silently vanish from the course."""
    for name in sorted(sources.discovery.definitions):
        if not (sources.curriculum / Path(name).parent / "exercices" / Path(name).name).is_dir():
            yield Problem(sources.code / "graders" / name, None, f"ce correcteur n’a pas d’exercice « {name} »")
