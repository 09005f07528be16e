"""Files for spreadsheets: what is written is read again, and nothing of it is a formula."""

from __future__ import annotations

import csv
import io
import re

import python_calamine
from hypothesis import given
from hypothesis import strategies as st

from server.marks.cells import WorkbookSheet, ascii_slug, build_xlsx, escape_formula, write_french_csv, write_plain_csv
from server.marks.means import format_number

DANGEROUS = "=+-@\t\r"
texts = st.text(st.characters(exclude_categories=("Cs",), exclude_characters="\x00"), max_size=12)
hostile = st.one_of(texts, st.builds(str.__add__, st.sampled_from([*DANGEROUS, " =", "\n=", "＝"]), texts))
cells = st.one_of(hostile, st.none(), st.integers(0, 2000).map(lambda hundredths: hundredths / 100))
rows = st.lists(st.tuples(cells, cells, cells), max_size=4)


@given(hostile)
def test_no_cell_begins_as_a_formula(text: str) -> None:
    safe = escape_formula(text)
    assert safe in {text, f"'{text}"}
    assert not safe.lstrip().startswith(tuple("=+-@＝＋－＠"))
    assert not safe.startswith(("\t", "\r", "\n"))


@given(rows)
def test_a_french_csv_is_read_again(lines: list[tuple[str | float | None, ...]]) -> None:
    content = b"".join(write_french_csv(("Nom", "=x", "é"), lines))
    text = content.decode("utf-8-sig")
    assert content.startswith(b"\xef\xbb\xbf")
    header, *found = csv.reader(io.StringIO(text, newline=""), delimiter=";")
    assert header == ["Nom", "'=x", "é"]
    assert found == [[_read(cell, ",") for cell in line] for line in lines]
    assert text.endswith("\r\n")
    if not any(isinstance(cell, str) for line in lines for cell in line):
        assert all(re.fullmatch(r'"[\d,]*"(;"[\d,]*"){2}', line) for line in text.split("\r\n")[1:-1])


def _read(cell: str | float | None, sign: str) -> str:
    return "" if cell is None else escape_formula(cell) if isinstance(cell, str) else format_number(cell, sign)


def test_plain_csv_has_decimal_points_and_no_bom() -> None:
    assert (
        b"".join(write_plain_csv(("a", "b"), [("é", 12.5), ("-1", None)]))
        == '"a","b"\r\n"é","12.5"\r\n"\'-1",""\r\n'.encode()
    )


def test_workbook_cells_have_their_types() -> None:
    evil = ["=1+1", "@x", "-1", "https://example.org", "12,5", "{=1}", " =1", "é\n2"]
    sheets = [
        WorkbookSheet("Notes", ("Nom", "Points"), [(text, 12.25) for text in evil] + [("", None)], 1),
        WorkbookSheet("Vide", ("a",), []),
    ]
    book = python_calamine.CalamineWorkbook.from_filelike(io.BytesIO(build_xlsx(sheets)))
    assert book.sheet_names == ["Notes", "Vide"]
    found = book.get_sheet_by_name("Notes").to_python(skip_empty_area=False)
    assert found[: len(evil) + 1] == [["Nom", "Points"], *([text, 12.25] for text in evil)]


def test_file_names_are_ascii() -> None:
    assert ascii_slug("MPSI 2 / « Été »", "classe") == "mpsi-2-ete"
    assert ascii_slug("日本", "classe") == "classe"
    assert re.fullmatch(r"[a-z-]{1,60}", ascii_slug("à" * 500, "x"))
