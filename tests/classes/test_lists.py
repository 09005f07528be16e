"""Lists as schools give them: whatever writes them, they are read as the same people, at the same lines."""

from __future__ import annotations

import csv
import io
import time
from contextlib import suppress

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from server.base.errors import Invalid
from server.classes import folding, sheets
from server.classes.codes import LETTERS, draw_join_code, format_join_code, parse_join_code
from server.classes.encodings import decode_text
from server.classes.models import NAME_LENGTH
from server.classes.roster import COLUMNS, read_roster
from server.classes.roster_line import RosterLine
from server.classes.rows import SheetRow
from server.classes.sheets import read_rows, to_csv
from tests.support.spreadsheets import ods, workbook, xlsx

NAMES = st.text("abcdefgh-' ,;\"0123éèïçœ", min_size=1, max_size=12).map(lambda text: " ".join(f"X {text}".split()))
PEOPLE = st.lists(st.tuples(NAMES, NAMES, st.sampled_from(["", "TP1", "TP1|SLAM"])), min_size=1, max_size=6)
ENCODINGS = st.sampled_from(["utf-8", "utf-8-sig", "cp1252", "utf-16"])


def written(people: list[tuple[str, str, str]], separator: str, end: str) -> str:
    out = io.StringIO(newline="")
    writer = csv.writer(out, delimiter=separator, lineterminator=end)
    writer.writerow(["Nom", "Prénom", "Identifiant", "Groupe"])
    writer.writerows(
        (family, given_name, f"id-{place}", group) for place, (family, given_name, group) in enumerate(people)
    )
    return out.getvalue()


def is_utf8(content: bytes) -> bool:
    with suppress(UnicodeDecodeError):
        return bool(content.decode())
    return False


@given(PEOPLE, ENCODINGS, st.sampled_from(";,\t"), st.sampled_from(["\n", "\r\n"]))
def test_a_list_is_read_whatever_wrote_it(
    people: list[tuple[str, str, str]], encoding: str, sep: str, end: str
) -> None:
    content = written(people, sep, end).encode(encoding)
    assume(encoding != "cp1252" or content.isascii() or not is_utf8(content))  # nobody could tell these apart
    roster = read_roster(content)
    assert roster.rejected == ()
    assert roster.lines == tuple(
        RosterLine(place + 2, family, given_name, "", f"id-{place}", tuple(filter(None, group.split("|"))))
        for place, (family, given_name, group) in enumerate(people)
    )


CELLS = st.text(st.characters(exclude_categories=["Cs"], exclude_characters="\x00"), max_size=8)
ROWS = st.lists(st.lists(CELLS, min_size=1, max_size=4).map(tuple), max_size=5)


@given(ROWS)
def test_rows_carried_as_text_come_back_at_the_same_lines(cells: list[tuple[str, ...]]) -> None:
    """From the preview to what is written."""
    line, rows = 1, []
    for one in cells:
        line += 2  # blank lines between
        if not SheetRow(line, one).is_blank:
            rows.append(SheetRow(line, one))
            line += sum(len(sheets.LINE_END.findall(cell)) for cell in one)
    assert read_rows(to_csv(rows).encode(), "utf-8").rows == tuple(rows)


def test_texts_longer_than_any_name_are_not_cached() -> None:
    long = "É " * 50_000
    before = folding._cached_fold.cache_info().currsize
    assert folding.normalise_name(long) == "e " * 49_999 + "e"
    assert folding.normalise_name("É" * NAME_LENGTH) == "e" * NAME_LENGTH
    assert folding._cached_fold.cache_info().currsize == before + 1


@given(st.binary(max_size=60))
@settings(max_examples=60)
def test_bytes_are_read_or_refused_in_a_sentence(content: bytes) -> None:
    with suppress(Invalid):
        roster = read_roster(b"nom;prenom\n" + content)
        assert all(one.line >= 2 for one in (*roster.lines, *roster.rejected))


@pytest.mark.parametrize(
    ("row", "reason"),
    [
        (";;;;", None),
        (";;a@example.org;;", "ni nom ni prénom"),
        (f"{'x' * 101};;;;", "dépasse 100"),
        ("A;B;pas une adresse;;", "adresse électronique"),
        ("A;B;;avec espace;", "sans espace"),
        (f"A;B;;;{'|'.join(map(str, range(25)))}", "24 groupes au plus"),
        ("A;B;;;;de trop", "plus de cases"),
        ("Premier;Un;;premier;", "même identifiant « premier » qu’à la ligne 2"),
    ],
)
def test_what_is_wrong_with_a_line_is_told_with_it(row: str, reason: str | None) -> None:
    roster = read_roster(f"{';'.join(COLUMNS)}\nPremier;Un;;premier;\n{row}\nDernier;Un;;;\n".encode())
    assert [(one.line, reason in one.reason) for one in roster.rejected if reason] == ([(3, True)] if reason else [])
    assert [line.family_name for line in roster.lines] == ["Premier", "Dernier"]


@pytest.mark.parametrize("first", ["Lovelace;Ada", "email;identifiant", "nom;nom", "nom de famille;Last name"])
def test_a_first_line_that_names_no_columns_is_refused(first: str) -> None:
    with pytest.raises(Invalid):
        read_roster(f"{first}\nA;B\n".encode())


SHEET: list[list[str | int]] = [["nom", "prénom", "identifiant"], ["Lovelace", "Ada", 12345], ["Turing", "Alan", "at"]]


@pytest.mark.parametrize("write", [xlsx, ods])
def test_spreadsheets_are_read(write) -> None:  # type: ignore[no-untyped-def]
    roster = read_roster(write(SHEET))
    assert [(one.line, one.name, one.login) for one in roster.lines] == [
        (2, "Ada Lovelace", "12345"),
        (3, "Alan Turing", "at"),
    ]


def test_a_spreadsheet_that_would_fill_the_memory_is_refused() -> None:
    """Some hundred bytes that stand for billions of cells."""
    far = '<sheetData><row r="1"><c r="A1"><v>1</v></c></row><row r="1048576"><c r="XFD1048576"><v>1</v></c></row>'
    long = xlsx([["nom"], ["x" * 1_100_000]])
    for content in (workbook(f"{far}</sheetData>"), ods(SHEET, repeated=1_000_000), long):
        assert len(content) < 4000
        with pytest.raises(Invalid):
            read_roster(content)


@given(st.lists(st.sampled_from(" -\t\u00a0"), min_size=9, max_size=9))
def test_a_code_is_read_however_it_is_typed(between: list[str]) -> None:
    code = draw_join_code()
    typed = "".join(sign + letter for sign, letter in zip(between, code.lower(), strict=False))
    assert parse_join_code(typed) == parse_join_code(format_join_code(code)) == code


@pytest.mark.parametrize("text", ["", "BCDFGHJ", "BCDFGHJKL", "ABCDFGHJ", "BCDFGHJ0", "BCDF GHJÉ", "B" * 1000])
def test_what_can_be_no_code_is_none(text: str) -> None:
    assert parse_join_code(text) is None
    assert len(set(LETTERS)) == 20


@pytest.mark.parametrize("word", ["é", "É", "ﬃ", "한", "Ã©", "aÉ", "a1´"])
def test_a_word_without_an_end_is_read_in_linear_time(word: str) -> None:
    """Each letter was compared with all that follow it."""

    def seconds(size: int) -> float:
        content, best = (word * (size // len(word))).encode(), float("inf")
        for _ in range(3):
            began = time.process_time()
            decode_text(content)
            best = min(best, time.process_time() - began)
        return best

    assert seconds(40_000) <= 8 * max(seconds(10_000), 0.005)
