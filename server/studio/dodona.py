"""An exercise of Dodona in a ZIP: its suite of tests with the files beside it, its statement, its solution."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import PurePath

from server.studio.import_drafts import ImportDraft, ImportRefused
from server.studio.tested import read_test_suite

SUITES = (".yaml", ".yml")
#: Languages of a statement, the first that is there.
LANGUAGES = ("fr", "en", "nl")
SEVERAL = "ce ZIP a {count} suites de tests ({names}) : n’en gardez qu’une"


@dataclass(frozen=True)
class SiblingFiles:
    """The texts of an exercise's files, found as a suite names them: by their path, or from its folders."""

    texts: Mapping[str, str]

    def find_text(self, name: str) -> str | None:
        ends = sorted(path for path in self.texts if f"/{path}".endswith(f"/{name.strip('/')}"))
        return self.texts[min(ends, key=len)] if ends else None


def has_suite(texts: Mapping[str, str]) -> bool:
    """Whether the files of a ZIP hold a suite of tests."""
    return any(PurePath(path).suffix.lower() in SUITES for path in texts)


def read_exercise(texts: Mapping[str, str]) -> Iterator[ImportDraft]:
    """Read an exercise's files, by their paths. Raises ImportRefused."""
    suites = sorted(path for path in texts if PurePath(path).suffix.lower() in SUITES)
    if len(suites) != 1:
        names = ", ".join(PurePath(path).name for path in suites[:5])
        raise ImportRefused(SEVERAL.format(count=len(suites), names=names))
    statement, solution = _find_statement(texts), _find_solution(texts)
    for draft in read_test_suite(
        texts[suites[0]].encode(), SiblingFiles(texts).find_text, solution=solution, statement=statement
    ):
        draft.title = _find_title(texts) or draft.title
        yield draft


def _find_statement(texts: Mapping[str, str]) -> str:
    paths = {PurePath(path).name: path for path in sorted(texts, reverse=True)}
    names = [*(f"description.{language}.md" for language in LANGUAGES), "description.md"]
    return next((texts[paths[name]].strip() for name in names if name in paths), "")


def _find_solution(texts: Mapping[str, str]) -> str:
    """Return the only program in Python of the solutions, or the one that is called so; empty without one."""
    programs = {path: text for path, text in texts.items() if path.endswith(".py") and "solution" in path}
    right = [path for path in sorted(programs) if PurePath(path).stem in ("solution", "correct")] or sorted(programs)
    return programs[right[0]] if right and (len(programs) == 1 or len(right) == 1) else ""


def _find_title(texts: Mapping[str, str]) -> str:
    card = next((text for path, text in sorted(texts.items()) if PurePath(path).name == "config.json"), "{}")
    try:
        names = json.loads(card).get("description", {}).get("names", {})
        return next((str(names[language]) for language in LANGUAGES if language in names), "")
    except (ValueError, RecursionError, AttributeError, TypeError):
        return ""
