"""The texts of a module as PDF files: the archive's own pages, printed by the Chromium that the machine has.

They are printed without scripts: what the style sheet for paper says is all that happens to them.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from collections.abc import Callable, Iterable
from pathlib import Path
from tempfile import TemporaryDirectory

from server.course import Course, Module
from server.offline.site import OfflineSite, Pictures
from server.reading.downloads import DownloadArchives

#: The shell without a window is the same engine, and the lightest.
BROWSERS = ("chromium-headless-shell", "chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
#: Seconds for one page; the longest takes some.
PATIENCE = 120.0
QUIET = ("--headless", "--disable-gpu", "--no-first-run", "--disable-background-networking", "--disable-extensions")
PRINTED = ("--no-pdf-header-footer", "--generate-pdf-document-outline")
#: Links that lead nowhere on paper, nor from a file that stands alone.
LOCAL_LINK = re.compile(r'(<a\b[^>]*?)\shref="(?!https?://|#)[^"]*"')
LAZY = re.compile(r'\sloading="lazy"')


class PrintError(Exception):
    """The browser gave no PDF: says which page, and what the browser said."""


def find_chromium() -> str | None:
    """The command of a Chromium, where the machine has one."""
    return next(filter(None, map(shutil.which, BROWSERS)), None)


def prepare_page_for_print(page: str) -> str:
    """A page of the archive for the printer: all its pictures at once, and no way to other files."""
    return LOCAL_LINK.sub(r"\1", LAZY.sub("", page))


def print_module_pdfs(
    course: Course,
    module: Module,
    pictures: Pictures,
    target: Path,
    *,
    command: str,
    slugs: Iterable[str] = (),
    advance: Callable[[], None] = lambda: None,
) -> list[Path]:
    """A PDF for each text of a module, answers of papers included, or for those of `slugs`; in the order of reading.

    Raises PrintError, and OSError where `target` cannot be written.
    """
    target.mkdir(parents=True, exist_ok=True)
    wanted = [lesson.slug for lesson in module.lessons if not slugs or lesson.slug in set(slugs)]
    made = []
    with TemporaryDirectory(prefix="balise-papier-") as folder:
        _write_files(
            OfflineSite(course, module, pictures, DownloadArchives(course), on_paper=True).files(), Path(folder)
        )
        for slug in wanted:
            made.append(_print_page_to_pdf(command, Path(folder) / "lire" / f"{slug}.html", target / f"{slug}.pdf"))
            advance()
    return made


def _write_files(files: dict[str, bytes], folder: Path) -> None:
    for name, content in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(prepare_page_for_print(content.decode()).encode() if path.suffix == ".html" else content)


def _print_page_to_pdf(command: str, page: Path, target: Path) -> Path:
    """By a browser of its own profile: one that is open on the machine is left alone."""
    with TemporaryDirectory(prefix="balise-chromium-") as profile:
        own = [f"--user-data-dir={profile}", *(["--no-sandbox"] if os.geteuid() == 0 else [])]
        asked = [command, *QUIET, *own, *PRINTED, f"--print-to-pdf={target.resolve()}", page.resolve().as_uri()]
        target.unlink(missing_ok=True)
        try:
            done = subprocess.run(asked, capture_output=True, text=True, timeout=PATIENCE, check=False)
        except subprocess.TimeoutExpired as error:
            raise PrintError(f"{page.stem} : le navigateur n’a pas fini en {PATIENCE:.0f} s") from error
    if done.returncode or not target.is_file():
        said = (done.stderr.strip().splitlines() or ["rien"])[-1]
        raise PrintError(f"{page.stem} : le navigateur a répondu « {said} »")
    return target
