"""The lessons of a module and its glossary, and the names by which its texts speak of each other."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

from graders.courses import module_folder
from server.course import glossary, retrievals, toml_file
from server.course.editions import MODULE_SLUG
from server.course.kinds import BY_FOLDER
from server.course.models import CourseFault, Drawing, Lesson, Problem
from server.course.objectives import build_objective
from server.course.schemas import FrontMatter
from server.text.markup import LabelTarget, LinkableLesson, MarkdownSource, MarkdownText, ModuleNames, PictureSize
from server.text.markup.blocks import EQUATION, KINDS
from server.text.markup.text import GLOSSARY, SLUG

NO_PAGES = {"exercices"}
PIXELS = 100  # a drawing's inch is shown as so many CSS pixels
FENCE = "+++"


@dataclass(eq=False)
class ModuleTexts:
    """What a module's folder has to read. Texts are read at the first need, all of them for the first name.

    Once the exercises are known, `exercises` (slug to title) and `questions` (`exercise/question`, where one ticks
    options) are filled in.
    """

    folder: Path
    drawings: Mapping[str, Drawing]
    problems: list[Problem]
    exercises: dict[str, str] = field(default_factory=dict)
    questions: set[str] = field(default_factory=set)
    paths: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.lessons = tuple(self._read_lessons())
        self.glossary = glossary.read_glossary(self.folder / glossary.FILE, self.linkable_names, self.problems)
        self.files = {path.stem: path for path in sorted((self.folder / "fichiers").glob("[!_.]*.py"))}
        self.replays = {path.stem.replace("_", "-") for path in (self.folder / "rejeux").glob("[!_.]*.py")}
        self.retrievals = retrievals.list_question_files(self.folder, self.problems)
        self.manipulations = {path.parent.name for path in self.folder.glob("manipulations/[!_.]*/scene.py")}

    def linkable_names(self) -> ModuleNames:
        return self._collect_names

    @cached_property
    def _collect_names(self) -> ModuleNames:
        labels = {label.id: label.target for label in self.placed_labels if label.first}
        return ModuleNames(
            module=self.folder.name,
            labels=labels,
            pages={lesson.slug: _lesson_name(lesson) for lesson in self.lessons},
            exercises=self.exercises,
            terms={term.id: term.word for term in self.glossary.values()},
            pictures={drawing.name: _picture_of_drawing(drawing) for drawing in self.drawings.values()},
            replays=self.replays,
            questions=self.questions,
            retrievals=self.retrievals,
            paths=self.paths,
            manipulations=self.manipulations,
            files=self.files,
            elsewhere=find_lesson_title,
        )

    @cached_property
    def placed_labels(self) -> tuple[PlacedLabel, ...]:
        return tuple(_numbered_labels(self.lessons))

    def _read_lessons(self) -> list[Lesson]:
        lessons: dict[str, Lesson] = {}
        for path in sorted(self.folder.glob("*/*.md")):
            if path.parent.name in NO_PAGES or path.name.startswith((".", "_")):
                continue
            try:
                lesson = self._read_lesson(path)
                if lesson.slug in lessons:
                    raise CourseFault(Problem(path, None, f"une autre page se nomme déjà « {lesson.slug} »"))
                lessons[lesson.slug] = lesson
            except CourseFault as fault:
                self.problems.append(fault.problem)
        return sorted(lessons.values(), key=lambda lesson: (lesson.kind.numbered, lesson.order, lesson.slug))

    def _read_lesson(self, path: Path) -> Lesson:
        kind = BY_FOLDER.get(path.parent.name)
        if kind is None:
            raise CourseFault(Problem(path, None, f"dossier de pages inconnu (connus : {', '.join(BY_FOLDER)})"))
        if not re.fullmatch(SLUG, path.stem) or path.stem == GLOSSARY:
            raise CourseFault(Problem(path, None, "nom de page : minuscules sans accent, chiffres et tirets"))
        card, body, line = _read_lesson_file(path)
        return Lesson(
            module=self.folder.name,
            slug=path.stem,
            kind=kind,
            title=card.title,
            label=card.label,
            order=card.order,
            minutes=card.minutes,
            summary=card.summary,
            objectives=tuple(card.objectives) + tuple(entry.text for entry in card.objective),
            skills=tuple(build_objective(entry, path.stem) for entry in card.objective),
            text=MarkdownText(MarkdownSource(body, path, line, page=path.stem, names=self.linkable_names)),
            solution=card.solution,
        )

    def find_text_problems(self, *, formulas: bool) -> Iterator[Problem]:
        """Everything that is wrong in the texts, but not so wrong that they cannot be served."""
        for lesson in self.lessons:
            yield from find_problems_in_text(lesson.text, formulas=formulas)
        for again in self.placed_labels:
            if not again.first:
                page = self.linkable_names().labels[again.id].page
                message = f"étiquette déjà prise par la page « {page} » : « #{again.id} »"
                yield Problem(again.path, again.target.line, message)
        for term in self.glossary.values():
            yield from find_problems_in_text(term.definition, formulas=formulas)
        yield from glossary.find_terms_of_unknown_lessons(
            self.folder / glossary.FILE, self.glossary, self.linkable_names().pages
        )


@dataclass(frozen=True)
class PlacedLabel:
    """A label where it stands; `first` is False where another lesson has it already."""

    id: str
    target: LabelTarget
    path: Path
    first: bool


def _numbered_labels(lessons: tuple[Lesson, ...]) -> Iterator[PlacedLabel]:
    """Labels in the order of the lessons, each kind counting for itself over the whole module."""
    counts: Counter[str] = Counter()
    owners: dict[str, str] = {}
    for lesson in lessons:
        text = lesson.text
        for label in text.outline.labels:
            kind = EQUATION if label.kind == "equation" else KINDS[label.kind]
            first = owners.setdefault(label.id, lesson.slug) == lesson.slug
            counts[label.kind] += kind.numbered and first
            number = counts[label.kind] if kind.numbered else 0
            target = LabelTarget(label.kind, kind.noun, number, lesson.slug, label.line)
            yield PlacedLabel(label.id, target, text.source.path, first)


def find_problems_in_text(text: MarkdownText, *, formulas: bool) -> Iterator[Problem]:
    for fault in text.find_faults(formulas=formulas):
        yield Problem(text.source.path, fault.line, fault.message)


def _lesson_name(lesson: Lesson) -> LinkableLesson:
    outline = lesson.text.outline
    figures = {name: number for number, name in enumerate(outline.figures, 1)}
    return LinkableLesson(lesson.title, frozenset(outline.anchors), figures)


def _picture_of_drawing(drawing: Drawing) -> PictureSize:
    width, height = drawing.size
    return PictureSize(drawing.alt, round(width * PIXELS), round(height * PIXELS))


def find_lesson_title(module: str, slug: str) -> str:
    """The title of a page of another module, wherever its course stands; empty where there is none."""
    if not (MODULE_SLUG.fullmatch(module) and re.fullmatch(SLUG, slug)):
        return ""
    folder = module_folder(module)
    for kind in BY_FOLDER:
        if (path := folder / kind / f"{slug}.md").is_file():
            with suppress(CourseFault):  # told where that module is read
                return read_front_matter(path).title
    return ""


def read_front_matter(path: Path) -> FrontMatter:
    """What a lesson says before its text. Raises CourseFault."""
    return _read_lesson_file(path)[0]


def _read_lesson_file(path: Path) -> tuple[FrontMatter, str, int]:
    """Front matter, body, and the line of the body's first character."""
    head, body, line = _split_front_matter(path, toml_file.read_text(path))
    return toml_file.parse_toml(head, path, FrontMatter, first_line=2), body, line


def _split_front_matter(path: Path, text: str) -> tuple[str, str, int]:
    """Front matter, body, and the line of the body's first character."""
    lines = text.split("\n")
    if lines[0].rstrip() != FENCE:
        raise CourseFault(Problem(path, 1, "une page commence par une ligne « +++ »"))
    end = next((number for number, line in enumerate(lines[1:], 1) if line.rstrip() == FENCE), None)
    if end is None:
        raise CourseFault(Problem(path, 1, "il manque la ligne « +++ » qui ferme l’en-tête"))
    return "\n".join(lines[1:end]), "\n".join(lines[end + 1 :]), end + 2
