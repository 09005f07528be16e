"""Sources of texts, names that they may refer to, and their faults."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field
from pathlib import Path

SLUG = r"[a-z0-9]+(?:[-_][a-z0-9]+)*"
GLOSSARY = "glossaire"  # a lesson that nobody writes


@dataclass(frozen=True)
class MarkupFault:
    """Something that would not come out as its author meant. `line` is a line of the file."""

    line: int
    message: str


class UnresolvedLink(Exception):
    """A link that leads nowhere; the message says why."""


@dataclass(frozen=True)
class LabelTarget:
    """What a label stands for: a block or an equation of a lesson. `number` is 0 where it has none."""

    kind: str
    noun: str
    number: int
    page: str
    line: int

    @property
    def display_name(self) -> str:
        """« théorème 1 », « (3) »; empty where nothing can be said without a number."""
        if not self.number:
            return ""
        return f"({self.number})" if self.kind == "equation" else f"{self.noun}\u00a0{self.number}"


@dataclass(frozen=True)
class LinkableLesson:
    """A lesson that can be linked to, and the places in it. `figures` have their numbers."""

    title: str
    anchors: Collection[str]
    figures: Mapping[str, int]


@dataclass(frozen=True)
class PictureSize:
    """A drawing as a page shows it; sizes are in CSS pixels."""

    alt: str
    width: int
    height: int


def still_drawing_name(manipulation: str) -> str:
    """The drawing that stands for a manipulation where there is no script."""
    return f"manipulation-{manipulation}"


@dataclass(frozen=True)
class ResolvedLink:
    """Where a link leads, and what to write where its author wrote nothing."""

    href: str
    text: str
    term: str = ""
    external: bool = False


def no_title_of_other_module(module: str, slug: str) -> str:
    """The title of a page of another module; empty where there is none."""
    return ""


@dataclass(frozen=True)
class ModuleNames:
    """Everything that the texts of a module may speak of, by name."""

    module: str = ""
    labels: Mapping[str, LabelTarget] = field(default_factory=dict)
    pages: Mapping[str, LinkableLesson] = field(default_factory=dict)
    exercises: Mapping[str, str] = field(default_factory=dict)
    terms: Mapping[str, str] = field(default_factory=dict)
    pictures: Mapping[str, PictureSize] = field(default_factory=dict)
    replays: Collection[str] = ()
    questions: Collection[str] = ()
    retrievals: Collection[str] = ()
    paths: Mapping[str, str] = field(default_factory=dict)
    manipulations: Collection[str] = ()
    files: Collection[str] = ()
    elsewhere: Callable[[str, str], str] = no_title_of_other_module

    def resolve_link(self, target: str, lesson: str) -> ResolvedLink:
        """Where `target`, written in `lesson`, leads. Raises Unresolved."""
        scheme, _, rest = target.partition(":")
        if target.startswith("#"):
            return self._resolve_label(target[1:], lesson)
        if scheme == "page":
            return self._resolve_page(*rest.partition("#")[::2])
        if scheme == "exo":
            return ResolvedLink(
                f"/{self.module}/exercices/{rest}", _lookup_or_raise(self.exercises, rest, "exercice inconnu")
            )
        if scheme == "terme":
            word = _lookup_or_raise(self.terms, rest, "terme inconnu du glossaire")
            return ResolvedLink(f"/{self.module}/{GLOSSARY}#t-{rest}", word, term=rest)
        if scheme == "fichier":
            if rest not in self.files:
                raise UnresolvedLink(f"fichier inconnu : « {rest} »")
            return ResolvedLink(f"/{self.module}/fichiers/{rest}.zip", f"{rest}.zip")
        if target.startswith("https://"):
            return ResolvedLink(target, "", external=True)
        raise UnresolvedLink(
            f"lien inconnu : « {target} » (possibles : #étiquette, page:, exo:, terme:, fichier:, https://)"
        )

    def _resolve_label(self, label: str, lesson: str) -> ResolvedLink:
        current, target = self.pages.get(lesson), self.labels.get(label)
        if current is not None and label in current.anchors:
            figure = current.figures.get(label.removeprefix("fig-")) if label.startswith("fig-") else None
            return ResolvedLink(
                f"#{label}", f"figure\u00a0{figure}" if figure else target.display_name if target else ""
            )
        if target is None:
            raise UnresolvedLink(f"étiquette inconnue : « #{label} »")
        return ResolvedLink(f"/{self.module}/lire/{target.page}#{label}", target.display_name)

    def _resolve_page(self, slug: str, anchor: str) -> ResolvedLink:
        module, apart, there = slug.partition("/")
        if apart:
            title = self.elsewhere(module, there)
            if not title or anchor:
                place = f"#{anchor}" if anchor else ""
                raise UnresolvedLink(f"page inconnue : « {slug}{place} » (d’un autre module : module/page, sans place)")
            return ResolvedLink(f"/{module}/lire/{there}", title)
        if slug == GLOSSARY:
            if anchor and anchor.removeprefix("t-") not in self.terms:
                raise UnresolvedLink(f"terme inconnu du glossaire : « {anchor} »")
            return ResolvedLink(f"/{self.module}/{GLOSSARY}" + (f"#{anchor}" if anchor else ""), "glossaire")
        lesson = self.pages.get(slug)
        if lesson is None:
            raise UnresolvedLink(f"page inconnue : « {slug} »")
        if anchor and anchor not in lesson.anchors:
            raise UnresolvedLink(f"la page « {slug} » n’a pas de « #{anchor} »")
        return ResolvedLink(
            f"/{self.module}/lire/{slug}" + (f"#{anchor}" if anchor else ""), "" if anchor else lesson.title
        )


def _lookup_or_raise(names: Mapping[str, str], name: str, error_message: str) -> str:
    if name not in names:
        raise UnresolvedLink(f"{error_message} : « {name} »")
    return names[name]


def no_module_names() -> ModuleNames:
    return ModuleNames()


@dataclass(frozen=True)
class MarkdownSource:
    """Markdown and where it comes from; `first_line` is the line of its first character in that file.

    `page` is the slug of the lesson it is, if it is one: labels, figures, replays and cells only stand in lessons.
    """

    text: str
    path: Path
    first_line: int = 1
    page: str = ""
    names: Callable[[], ModuleNames] = no_module_names
