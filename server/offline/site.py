"""The files of a module's archive: every page as a visitor sees it, with addresses that need no service.

The figures come from outside (`pictures`): the service has a process that draws them, the command line draws here.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

from markupsafe import Markup

from server.base.files import ROOT, TEMPLATES, digest_files, reproducible_zip
from server.course import Course, Exercise, Module
from server.figures import drawing_requests
from server.figures.drawing_requests import Theme
from server.offline.addresses import ON_THE_SERVER, ArchiveLinkRewriter
from server.offline.schemas import OfflineExercise
from server.reading import gates
from server.reading import service as reading
from server.reading.downloads import DownloadArchives
from server.replays import service as replays
from server.text.markup.text import still_drawing_name
from server.web import assets
from server.web.rendering import build_account_view, jinja_environment
from server.web.views import build_module_link, exercise_href, lesson_href

#: A picture of the texts, by the drawing's name and the theme.
Pictures = Mapping[tuple[str, Theme], bytes]
THEMES: tuple[Theme, ...] = ("light", "dark")
#: What of the front end the pages of an archive may ask for; style sheets ask for the rest by themselves.
STYLES = ("css", "katex", "img")
SCRIPTS = ("js/theme.js", "js/offline.js")
EXCLUDED_SUFFIXES = {".js"}


def archive_content_digest(module: Module) -> str:
    """Return a digest of everything that an archive is made from."""
    parts = [
        (module.slug, module.folder),
        ("templates", TEMPLATES),
        ("graders", ROOT / "graders" / "scene"),
        ("reading", ROOT / "server" / "reading"),
        ("text", ROOT / "server" / "text"),
        ("offline", Path(__file__).parent),
    ]
    return digest_files(parts, f"{assets.frontend_version_tag()} {drawing_requests.drawing_code_digest()}".encode())


def list_needed_pictures(module: Module) -> list[tuple[str, Theme]]:
    """The pictures that an archive needs: those that its lessons show, and those that stand for manipulations."""
    named = (name for lesson in module.lessons for name in (*lesson.figures, *lesson.stills))
    shown = dict.fromkeys(name for name in named if name in module.drawings)
    return [(name, theme) for name in shown for theme in THEMES]


def build_archive_zip(course: Course, module: Module, pictures: Pictures, downloads: DownloadArchives) -> bytes:
    """A ZIP whose files stand in one folder. Slow at first (formulas, replays: seconds): call it in a thread."""
    return reproducible_zip(archive_folder_name(module), OfflineSite(course, module, pictures, downloads).files())


def archive_folder_name(module: Module) -> str:
    return f"balise-{module.slug}"


class OfflineSite:
    """One module, to be written once. `on_paper`: to be printed here, with the answers of papers and no script."""

    def __init__(
        self, course: Course, module: Module, pictures: Pictures, downloads: DownloadArchives, *, on_paper: bool = False
    ) -> None:
        self._course, self._module, self._downloads = course, module, downloads
        self._on_paper = on_paper
        #: Those whose text is shown: what the others show would tell it.
        self._shown = [lesson for lesson in module.lessons if on_paper or not lesson.solution]
        names = {name for lesson in self._shown for name in (*lesson.figures, *lesson.stills)}
        self._pictures = {key: picture for key, picture in pictures.items() if key[0] in names}
        self._scripts = replays.ReplayLibrary()
        self._places = ArchiveLinkRewriter(assets.static_url_prefix(), dict(self._iter_addresses_and_paths()))

    def files(self) -> dict[str, bytes]:
        """By their places in the archive."""
        made = {place: self._places.relative(page, place).encode() for place, page in self._render_pages()}
        return {**made, **dict(self._iter_assets()), **_read_static_files()}

    def _iter_addresses_and_paths(self) -> Iterator[tuple[str, str]]:
        """The address of everything that the archive holds, and its place there."""
        slug = self._module.slug
        yield f"/{slug}", "index.html"
        if self._module.glossary:
            yield f"/{slug}/glossaire", "glossaire.html"
        for lesson in self._module.lessons:
            yield lesson_href(lesson), f"lire/{lesson.slug}.html"
        for exercise in self._module.exercises:
            yield exercise_href(exercise), f"exercices/{exercise.slug}.html"
        for name, theme in self._pictures:
            yield f"/{slug}/figures/{name}.svg?theme={theme}", f"figures/{name}-{theme}.svg"
        for name in self._replay_names():
            yield f"/{slug}/rejeux/{name}", f"rejeux/{name}.js"
        for name in self._serverless_manipulation_names():
            yield f"/{slug}/manipulations/{name}", f"manipulations/{name}.js"
        for name in self._module.files:
            yield f"/{slug}/fichiers/{name}.zip", f"fichiers/{name}.zip"
        if slug in self._module.kits:
            yield f"/{slug}/kit/{slug}.py", f"{slug}.py"

    def _replay_names(self) -> list[str]:
        if self._on_paper:
            return []
        return list(dict.fromkeys(name for lesson in self._shown for name in lesson.replays))

    def _serverless_manipulation_names(self) -> list[str]:
        """Return the names of the manipulations that need no server once they have begun."""
        if self._on_paper:
            return []
        shown = {still for lesson in self._shown for still in lesson.stills}
        names = self._scripts.manipulation_names(self._module.slug)
        return [
            name
            for name in names
            if still_drawing_name(name) in shown and self._scripts.needs_no_server(self._module.slug, name)
        ]

    def _render_pages(self) -> Iterator[tuple[str, str]]:
        module = self._module
        yield "index.html", self._render_page("module.html", page=reading.build_home_view(module, {}, (), {}))
        yield ON_THE_SERVER, self._render_page("offline/server.html")
        if module.glossary:
            yield "glossaire.html", self._render_page("reading/glossary.html", page=reading.build_glossary_page(module))
        for lesson in module.lessons:
            gate = gates.ONLINE if lesson.solution and not self._on_paper else None
            view = reading.build_lesson_view(module, lesson, {}, None, gate)
            yield f"lire/{lesson.slug}.html", self._render_page("reading/lesson.html", page=view)
        for exercise in module.exercises:
            page = self._render_page("offline/exercise.html", page=self._build_exercise(exercise))
            yield f"exercices/{exercise.slug}.html", page

    def _render_page(self, template: str, **context: Any) -> str:
        module = self._module
        around = {"base": "offline/base.html", "module": build_module_link(module), "terms": len(module.glossary)}
        visitor = {"account": build_account_view(None), "scripts": assets.is_frontend_built() and not self._on_paper}
        return jinja_environment().get_template(template).render(**around, **visitor, **context)

    def _build_exercise(self, exercise: Exercise) -> OfflineExercise:
        lesson = next((candidate for candidate in self._module.lessons if candidate.slug == exercise.seance), None)
        return OfflineExercise(
            module=build_module_link(self._module),
            title=exercise.title,
            summary=exercise.summary,
            stars=exercise.stars,
            lesson=(lesson_href(lesson), lesson.label) if lesson else None,
            functions=exercise.functions,
            statement=Markup(exercise.statement_html),
            starter=exercise.starter if exercise.kind == "code" else "",
            file=f"{exercise.slug}.py",
        )

    def _iter_assets(self) -> Iterator[tuple[str, bytes]]:
        """Yield the files of the archive that are not pages."""
        slug = self._module.slug
        for (name, theme), picture in self._pictures.items():
            yield f"figures/{name}-{theme}.svg", picture
        for name in self._replay_names():
            yield f"rejeux/{name}.js", self._offline_replay_script(name)
        for name in self._serverless_manipulation_names():
            yield f"manipulations/{name}.js", self._manipulation_script(name)
        for name in self._module.files:
            yield f"fichiers/{name}.zip", self._downloads.build_archive(slug, name)
        if slug in self._module.kits:
            yield f"{slug}.py", "".join(self._module.kits[slug].values()).encode()

    def _offline_replay_script(self, name: str) -> bytes:
        """A replay as a script, as a folder's page may not fetch: as it begins, and as its prediction plays it."""
        script = self._scripts.find(self._module.slug, name)
        asked = script.prediction.settings if script.prediction else {}
        settings = [{}, dict(asked)] if asked else [{}]
        scenes = {
            _compact_json(sorted(setting.items())): script.run(script.read(setting.items())) for setting in settings
        }
        return f"globalThis.baliseScenes[{json.dumps(name)}] = {_compact_json(scenes)};\n".encode()

    def _manipulation_script(self, name: str) -> bytes:
        """A manipulation as a script: what it begins with, and its own scripts as texts."""
        begins = self._scripts.find_manipulation(self._module.slug, name)
        brought = {"scene": begins.run(begins.read([])), "scripts": self._scripts.scripts(self._module.slug, name)}
        return f"globalThis.baliseHands[{json.dumps(name)}] = {_compact_json(brought)};\n".encode()


def _compact_json(value: Any) -> str:
    return json.dumps(value, ensure_ascii=False, separators=(",", ":"), allow_nan=False)


def _read_static_files() -> dict[str, bytes]:
    """Style sheets and what they ask for; scripts where they were built, as a folder's modules are refused."""
    root = assets.static_folder()
    styles = [path for name in STYLES for path in (root / name).rglob("*") if path.suffix not in EXCLUDED_SUFFIXES]
    scripts = [root / name for name in SCRIPTS] if assets.is_frontend_built() else []
    wanted = [path for path in (*styles, *scripts) if path.is_file()]
    return {f"static/{path.relative_to(root).as_posix()}": path.read_bytes() for path in wanted}


def draw_pictures_in_process(module: Module, advance: Callable[[], None] = lambda: None) -> Pictures:
    """The pictures, drawn in this very process. Loads matplotlib; half a minute for a module."""
    from server.figures.lessons import draw_lesson_figure

    pictures = {}
    for name, theme in list_needed_pictures(module):
        pictures[name, theme] = draw_lesson_figure(module.drawings[name], theme, "svg").picture
        advance()
    return pictures
