"""Texts of files: one graph, map, log or trajectory, whatever saved it; and errors that name the line as it is seen."""

import codecs
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from reference.errors import InvalidArgumentError
from reference.formats.carmen import parse_flaser
from reference.formats.map_server import read_description
from reference.formats.pgm import read_pgm
from reference.formats.trajectory_files import read_kitti, read_tum
from reference.planning.moving_ai import parse_map, parse_scenarios
from reference.pose_graph import dumps_g2o, loads_g2o
from reference.text import decode_and_normalize, decode_lines
from reference.world.grid_map import GridMap
from tests.support.tables import folded

TUM = "# été\n1.5 0 0 0 0 0 0 1\n2.5 1 0 0 0 0 0 1\n"
KITTI = "1 0 0 0 0 1 0 0 0 0 1 0\n"
G2O = "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0\nEDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n"
YAML = "image: été.pgm\nresolution: 0.05\norigin: [0, 0, 0]\n"
LOG = "FLASER 4 1.0 2.5 81.83 3 0.1 0.2 0.3 0.4 0.5 0.6 12.5 pippo 12.5\n"
CELLS = "type octile\nheight 2\nwidth 3\nmap\n.@G\nTS.\n"
SCENARIOS = "version 1\n3\tm.map\t3\t2\t0\t1\t2\t0\t2.41421\n"

READERS: dict[str, tuple[Callable[[Any], Any], str]] = {
    "tum": (lambda text: read_tum(text).times.tolist(), TUM),
    "kitti": (lambda text: read_kitti(text).tolist(), KITTI),
    "g2o": (lambda text: dumps_g2o(loads_g2o(text)), G2O),
    "yaml": (read_description, YAML),
    "carmen": (lambda text: parse_flaser(text, 50.0).scans[0].ranges.tolist(), LOG),
    "moving_ai": (lambda text: parse_map(text).tolist(), CELLS),
    "scenarios": (parse_scenarios, SCENARIOS),
    "grid_map": (lambda text: GridMap.from_text(text).to_text(), "..\n.#\n"),
    "pgm": (
        lambda text: read_pgm(text if isinstance(text, bytes) else text.encode()).pixels.tolist(),
        "P2\n2 1 9\n3 4\n",
    ),
}
SAVED: dict[str, Callable[[str], str | bytes]] = {
    "str with a mark": lambda text: "\ufeff" + text,
    "UTF-8 with a mark": lambda text: text.encode("utf-8-sig"),
    "UTF-8": str.encode,
    "UTF-16 LE": lambda text: codecs.BOM_UTF16_LE + text.encode("utf-16-le"),
    "UTF-16 BE": lambda text: codecs.BOM_UTF16_BE + text.encode("utf-16-be"),
    "UTF-16 LE without a mark": lambda text: text.encode("utf-16-le"),
    "UTF-16 BE without a mark": lambda text: text.encode("utf-16-be"),
    "UTF-32": lambda text: text.encode("utf-32"),
    "Windows-1252": lambda text: text.encode("cp1252"),
    "a mark read as Windows-1252": lambda text: "ï»¿" + text,
}


@folded("end", ["\n", "\r\n", "\r"])
@folded("saved", SAVED)
@folded("reader", READERS)
def test_a_file_is_read_alike_whatever_saved_it(reader: str, saved: str, end: str) -> None:
    read, text = READERS[reader]
    assert read(SAVED[saved](text.replace("\n", end))) == read(text)


def test_files_put_one_behind_the_other_have_marks_inside() -> None:
    assert read_tum(("\ufeff" + TUM) * 2).times.tolist() == [1.5, 2.5, 1.5, 2.5]


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_a_line_is_counted_as_editors_count_it(end: str) -> None:
    """A form feed or a separator within a comment ends no line."""
    text = end.join(["\ufeff# a\x0cb\x0b\x1c\x85\u2028c", "1 0 0 0 0 0 0 1", "1 x"])
    with pytest.raises(InvalidArgumentError, match="line 3 "):
        read_tum(text.encode())
    with pytest.raises(InvalidArgumentError, match="line 3:"):
        loads_g2o(text.replace("1 0 0 0 0 0 0 1", "VERTEX_SE2 0 0 0 0"))


def test_lines_have_no_empty_one_behind_the_last() -> None:
    assert decode_lines("") == []
    assert decode_lines("a\r\n\r\nb\r") == ["a", "", "b"]
    assert decode_and_normalize(b"") == ""


@pytest.mark.parametrize(
    "data",
    [
        codecs.BOM_UTF8 + b"1\n2\n\xff",
        codecs.BOM_UTF16_LE + "1\n2\n".encode("utf-16-le") + b"\x00",
        b"1\n2\n\x00\xff",
    ],
)
def test_bytes_that_are_no_text_are_refused_with_their_line(data: bytes) -> None:
    with pytest.raises(InvalidArgumentError, match="line 3 is no text"):
        decode_and_normalize(data)


@pytest.mark.parametrize(
    "broken",
    [
        CELLS.replace("type", "kind"),
        CELLS.replace("height 2\nwidth 3", "width 3\nheight 2"),
        CELLS + "...\n",
        CELLS.replace("map\n", ""),
    ],
)
def test_a_drawn_map_that_does_not_add_up_is_refused(broken: str) -> None:
    with pytest.raises(InvalidArgumentError):
        parse_map(broken)


def test_a_log_with_more_ranges_than_announced_is_refused() -> None:
    """Read on, its pose would begin with a range."""
    for line in (LOG.replace("FLASER 4", "FLASER 3"), LOG.replace("FLASER 4", "FLASER 5")):
        with pytest.raises(InvalidArgumentError, match="line 2"):
            parse_flaser(f"# a log\n{line}", 50.0)


def test_a_matrix_that_is_no_rotation_is_named_by_its_line() -> None:
    with pytest.raises(InvalidArgumentError, match="line 3"):
        read_kitti(f"# first\n{KITTI}2 0 0 0 0 1 0 0 0 0 1 0\n")
    np.testing.assert_array_equal(read_kitti(KITTI)[0], np.eye(4))
