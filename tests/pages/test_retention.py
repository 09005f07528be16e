"""What is kept, and how long, is told once, of every table, by the settings in force, on the page and in the docs."""

from __future__ import annotations

import html
import re
from collections import Counter

import pytest

from server.base.files import ROOT
from server.base.settings import Settings
from server.pages.retention import RetentionRow, list_retention_rows
from server.tables import metadata
from tests.support.service import Site

DOC = ROOT / "server" / "docs" / "conservation.md"
NOBODY_S = {"alembic_version"}


def table(settings: Settings) -> list[str]:
    """The lines of the docs' table."""
    return [
        f"| {row.what} | {row.kept} | {where(row)} | {', '.join(f'`{name}`' for name in row.variables) or '—'} "
        f"| {row.removed} |".replace("\u00a0", " ")
        for row in list_retention_rows(settings)
    ]


def plain(text: str) -> str:
    """Without what French typography adds."""
    return text.replace("\u00a0", " ").replace("\u202f", " ")


def where(row: RetentionRow) -> str:
    return ", ".join(f"`{name}`" for name in row.tables) or ", ".join(row.places) or "les mêmes tables"


def test_each_table_of_the_database_is_told_once() -> None:
    told = Counter(name for row in list_retention_rows(Settings()) for name in row.tables)
    assert told.keys() == metadata.tables.keys() - NOBODY_S
    assert set(told.values()) == {1}
    for row in list_retention_rows(Settings()):
        assert row.what
        assert row.kept
        assert row.removed
        assert set(row.settings) <= Settings.model_fields.keys()


def test_every_setting_that_erases_is_told() -> None:
    told = {name for row in list_retention_rows(Settings()) for name in row.settings}
    erasing = {name for name in Settings.model_fields if re.search(r"_(days|hours)$", name)}
    assert erasing <= told


@pytest.mark.parametrize(
    ("name", "value", "said"),
    [
        ("session_days", 12, "12\u00a0jours"), ("api_token_days", 1, "1\u00a0jour"), ("guest_days", 9, "9\u00a0jours"),
        ("password_link_hours", 7, "7\u00a0heures"), ("first_password_days", 3, "3\u00a0jours"),
        ("left_days", 90, "90\u00a0jours"), ("silent_days", 700, "700\u00a0jours"),
    ],
)  # fmt: skip
def test_the_settings_in_force_are_told(name: str, value: int, said: str) -> None:
    changed = [row.kept for row in list_retention_rows(Settings(**{name: value})) if name in row.settings]  # type: ignore[arg-type]
    assert any(re.search(rf"(?<!\d){said}(?!\w)", kept) for kept in changed)


def test_the_page_shows_each_row_with_the_settings_in_force(site: Site) -> None:
    site.tighten(session_days=77, silent_days=400)
    page = plain(html.unescape(site.client.get("/donnees-personnelles").text))
    for row in list_retention_rows(site.settings.model_copy(update={"session_days": 77, "silent_days": 400})):
        assert all(plain(text) in page for text in (row.what, row.kept, row.removed)), row.what


def test_the_docs_tell_the_same_of_the_settings_by_default() -> None:
    lines = [line for line in DOC.read_text(encoding="utf-8").splitlines() if line.startswith("| ")]
    assert lines[1:] == table(Settings())
