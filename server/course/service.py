"""Discovery of the course: what is well formed is served, what is not is reported with its place."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterable, Iterator
from dataclasses import replace
from enum import Enum
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, TypeVar

from graders import courses
from graders.core.contract.kits import find_kits
from server.course import drawings, filing, reuse, toml_file
from server.course.closure import ImportGraph
from server.course.editions import MODULE_SLUG, module_number_of_slug
from server.course.graded import ExerciseSources, exercise_id_of_folder, read_graded_exercise, read_python_that_compiles
from server.course.library import ModuleTexts, find_problems_in_text
from server.course.models import Course, CourseFault, Exercise, FunctionSpec, Module, Problem, ReadingPath
from server.course.schemas import ExerciseFile, ModuleFile
from server.course.start_cache import NO_FACTS, StartCache, digest_sources
from server.course.toml_places import find_line_of_value
from server.course.version import grader_folder
from server.text.markup import MarkdownSource, MarkdownText, ModuleNames

if TYPE_CHECKING:
    from graders.discovery import Discovery

T = TypeVar("T")
MALFORMED_MODULE_NAME = (
    "nom de module : des minuscules puis un nombre, comme « l20 » ; sa deuxième édition est « l20e2 »"
)
EXERCISE_SLUG = re.compile(r"[a-z0-9]+(_[a-z0-9]+)*")
HINT_TITLE = re.compile(r"^##[ \t]+Indice[ \t]+(\d+)[ \t]*$", re.MULTILINE)


class TextChecking(Enum):
    """How closely the texts are looked at while the course is loaded."""

    no = "they are read when they are asked for"
    read = "what they say of each other is followed, but no formula is drawn"
    drawn = "all of it"


def load_course(
    curriculum: Path | None = None,
    *,
    code: Path | None = None,
    discovery: Discovery | None = None,
    render: bool = True,
    check: bool = False,
    memory: StartCache | None = None,
    only: str = "",
) -> Course:
    """Read the whole course. Never raises for a malformed module or exercise: see `Course.problems`.

    All courses are read, unless `curriculum` is one's; `code` holds `graders/` and `reference/`, which versions cover.
    Rendering all the texts takes seconds, most of it for the formulas. With `render=False` a text is rendered when it
    is looked at, and its faults are not looked for; with `check=True` too, all of its faults are, but for those of
    formulas: once, where `memory` says that these very files were sound. Their graders are then loaded when they are
    asked for, whoever reads them. With `only`, an exercise ("l20/poses") is read alone, with those that it reuses.
    """
    memory = memory or StartCache()
    look = TextChecking.drawn if render else TextChecking.read if check else TextChecking.no
    curricula = (curriculum,) if curriculum else tuple(courses.room_folders(courses.CURRICULUM))
    roots = (code,) if code else tuple(courses.COURSES.folders)
    checked = look is TextChecking.read
    source = digest_sources(curricula, roots) if checked or memory.has_sound_course else ""
    known = memory.exercise_facts(source) if source else NO_FACTS
    if source and memory.is_known_sound(source):
        look = TextChecking.no
    wanted = reuse.exercise_ids_with_reused(curricula, only) if only else None
    if discovery is None and not known:
        from graders.discovery import discover

        discovery = discover(wanted)
    amiss = discovery.problems if discovery else courses.COURSES.problems
    problems = [Problem(problem.path, problem.line, problem.message) for problem in amiss]
    sources = ExerciseSources(curricula, roots, discovery, ImportGraph(*roots, memory=memory), known)
    modules = _build_all(
        problems, lambda path: _load_module(sources, path, problems, look, wanted), _module_folders(curricula, only)
    )
    modules.sort(key=lambda module: (module.order, module.slug))
    problems.extend(_find_graders_without_exercise(sources))
    problems.extend(_find_duplicate_kits(modules))
    families = filing.read_families(curricula, problems)
    if checked:
        memory.save_used_entries("" if problems else source, {} if problems else sources.found)
    return Course(MappingProxyType({module.slug: module for module in modules}), tuple(problems), families)


def _build_all(problems: list[Problem], build: Callable[[Path], T], paths: list[Path]) -> list[T]:
    """What `build` makes of each path; where it cannot, its problem is noted and the others go on."""
    built = []
    for path in paths:
        try:
            built.append(build(path))
        except CourseFault as fault:
            problems.append(fault.problem)
    return built


def _module_folders(curricula: Iterable[Path], only: str) -> list[Path]:
    there = (path for curriculum in curricula for path in curriculum.iterdir() if path.is_dir())
    folders = sorted(path for path in there if not path.name.startswith((".", "__")))
    return [path for path in folders if not only or path.name == only.partition("/")[0]]


def _exercise_folders(module: Path, wanted: Collection[str] | None) -> list[Path]:
    folder = module / "exercices"
    found = sorted(path for path in folder.iterdir() if path.is_dir()) if folder.is_dir() else []
    return [path for path in found if wanted is None or exercise_id_of_folder(path) in wanted]


def _load_module(
    sources: ExerciseSources, path: Path, problems: list[Problem], look: TextChecking, wanted: Collection[str] | None
) -> Module:
    if not MODULE_SLUG.fullmatch(path.name):
        raise CourseFault(Problem(path, None, MALFORMED_MODULE_NAME))
    card = toml_file.read_toml(path / "module.toml", ModuleFile)
    kits = {
        name: {place: read_python_that_compiles(file) for place, file in files.items()}
        for name, files in find_kits(path).items()
    }
    library = ModuleTexts(path, drawings.read_drawings(path / "figures", problems), problems)
    library.paths = {way.name: way.title for way in card.paths if way.name}
    sources = replace(sources, names=library.linkable_names)
    exercises = _build_all(
        problems, lambda folder: _load_exercise(sources, path, folder), _exercise_folders(path, wanted)
    )
    exercises = reuse.add_transitive_reuses(path / "exercices", exercises, problems)
    exercises.sort(key=lambda exercise: (exercise.stars, exercise.order, exercise.slug))
    library.exercises.update({exercise.slug: exercise.title for exercise in exercises})
    library.questions.update(
        f"{exercise.slug}/{name}" for exercise in exercises for name in sources.found[exercise.id].ticked
    )
    if look is not TextChecking.no:
        exercises = [
            exercise for exercise in exercises if not _add_problems(problems, _find_exercise_faults(exercise, look))
        ]
        _add_problems(problems, library.find_text_problems(formulas=look is TextChecking.drawn))
        _add_problems(problems, _find_unknown_lessons(path, exercises, library))
        _add_problems(
            problems,
            _find_module_file_problems(path / "module.toml", card, library, formulas=look is TextChecking.drawn),
        )
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
        order=module_number_of_slug(path.name) if card.order is None else card.order,
        kits=MappingProxyType(kits),
        exercises=tuple(exercises),
        lessons=library.lessons,
        glossary=MappingProxyType(library.glossary),
        drawings=MappingProxyType(library.drawings),
        files=MappingProxyType(library.files),
        paths=tuple(
            ReadingPath(way.title, way.summary, way.page, tuple(way.exercises), way.name) for way in card.paths
        ),
        retrievals=MappingProxyType(dict(library.retrievals)),
        names=library.linkable_names,
        folder=path,
    )


def _add_problems(problems: list[Problem], new: Iterable[Problem]) -> bool:
    """True where there were some."""
    before = len(problems)
    problems.extend(new)
    return len(problems) > before


def _find_exercise_faults(exercise: Exercise, look: TextChecking) -> Iterator[Problem]:
    for text in (exercise.statement, *exercise.hint_texts):
        yield from find_problems_in_text(text, formulas=look is TextChecking.drawn)
    if exercise.answers is not None:
        from server.course import questions

        path = exercise.statement.source.path.with_name(questions.FILE)
        yield from questions.find_question_text_problems(
            path, exercise.answers, exercise.names, formulas=look is TextChecking.drawn
        )


def _find_unknown_lessons(module: Path, exercises: list[Exercise], library: ModuleTexts) -> Iterator[Problem]:
    """Exercises that are said to follow a lesson that does not exist."""
    lessons = {lesson.slug for lesson in library.lessons}
    for exercise in exercises:
        if exercise.seance and exercise.seance not in lessons:
            path = module / "exercices" / exercise.slug / "exercise.toml"
            line = find_line_of_value(toml_file.read_text(path), ("seance",))
            yield Problem(path, line, f"« seance » : page inconnue « {exercise.seance} »")


def _find_module_file_problems(
    path: Path, card: ModuleFile, library: ModuleTexts, *, formulas: bool
) -> Iterator[Problem]:
    """Its paths and its references, each of which may lead somewhere."""
    source = toml_file.read_text(path)
    for number, course_path in enumerate(card.paths):
        if library.linkable_names().pages.get(course_path.page.partition("#")[0]) is None:
            message = f"« page » : page inconnue « {course_path.page} »"
            yield Problem(path, find_line_of_value(source, ("paths", number, "page")), message)
        for place, slug in enumerate(course_path.exercises):
            if not (path.parent / "exercices" / slug).is_dir():
                line = find_line_of_value(source, ("paths", number, "exercises", place))
                yield Problem(path, line, f"« exercises » : exercice inconnu « {slug} »")
    for number, reference in enumerate(card.references):
        line = find_line_of_value(source, ("references", number))
        yield from find_problems_in_text(
            MarkdownText(MarkdownSource(reference, path, line or 1, names=library.linkable_names)), formulas=formulas
        )


def _load_exercise(sources: ExerciseSources, module: Path, path: Path) -> Exercise:
    if not EXERCISE_SLUG.fullmatch(path.name):
        raise CourseFault(Problem(path, None, "nom d’exercice : minuscules, chiffres et « _ »"))
    card = toml_file.read_toml(path / "exercise.toml", ExerciseFile)
    graded = read_graded_exercise(sources, path, card)
    return Exercise(
        module=module.name,
        slug=path.name,
        title=card.title,
        summary=card.summary,
        order=card.order,
        stars=card.stars,
        origin=card.origin,
        functions=tuple(
            FunctionSpec(
                function.name,
                function.signature,
                function.returns,
                function.doc,
                tuple(function.parts),
                function.example,
                tuple(graded.found.promises.get(function.name, ())),
            )
            for function in card.functions
        ),
        starter=graded.starter,
        solution=graded.solution,
        make=graded.make,
        statement=MarkdownText(
            MarkdownSource(toml_file.read_text(path / "enonce.md"), path / "enonce.md", names=sources.names)
        ),
        hint_texts=_read_hints(path / "indices.md", sources.names),
        names=sources.names,
        version=graded.found.version,
        kit=graded.found.kit,
        kind=card.kind,
        seance=card.seance,
        policy=card.limits.build_policy(),
        reuses=tuple(card.reuses),
        filing=filing.read_exercise_families(path),
        hunts=card.hunts,
    )


def _read_hints(path: Path, names: Callable[[], ModuleNames]) -> tuple[MarkdownText, MarkdownText, MarkdownText]:
    text = toml_file.read_text(path)
    titles = list(HINT_TITLE.finditer(text))
    if [title[1] for title in titles] != ["1", "2", "3"]:
        line = text[: titles[-1].start()].count("\n") + 1 if titles else 1
        raise CourseFault(Problem(path, line, "il faut trois parties : « ## Indice 1 », « 2 » puis « 3 »"))
    ends = [*(title.start() for title in titles[1:]), len(text)]
    first, second, third = (
        _slice_hint_text(path, text, title.end(), end, names) for title, end in zip(titles, ends, strict=True)
    )
    return first, second, third


def _slice_hint_text(path: Path, text: str, start: int, end: int, names: Callable[[], ModuleNames]) -> MarkdownText:
    line = text[:start].count("\n") + 1
    if not text[start:end].strip():
        raise CourseFault(Problem(path, line, "indice vide"))
    return MarkdownText(MarkdownSource(text[start:end], path, line, names=names))


def _find_graders_without_exercise(sources: ExerciseSources) -> Iterator[Problem]:
    """Graders without an exercise: a renamed folder must not silently vanish from the course."""
    for name in sorted(sources.discovery.definitions if sources.discovery is not None else ()):
        module, slug = name.split("/")
        if not any((room / module / "exercices" / slug).is_dir() for room in sources.curricula):
            yield Problem(
                grader_folder(sources.code, module, slug), None, f"ce correcteur n’a pas d’exercice « {name} »"
            )


def _find_duplicate_kits(modules: list[Module]) -> Iterator[Problem]:
    """Kits that two modules call the same: programs would find one for the other."""
    homes: dict[str, Path] = {}
    for module in modules:
        for name in module.kits:
            other = homes.setdefault(name, module.folder)
            if other != module.folder:
                message = f"la trousse « {name} » existe déjà dans {other / 'kit'} : renommez l’une des deux"
                yield Problem(module.folder / "kit", None, message)
