"""Maps of ROS: round trips, Pillow and PyYAML as second readers, the interpretation of every shade, and a real map."""

import io
import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from reference.formats.map_server import (
    MapDescription,
    MapFileError,
    OccupancyGrid,
    read_description,
    read_map,
    write_description,
    write_map,
)
from reference.formats.pgm import GreyImage, PgmError, read_pgm, write_pgm
from reference.world.grid_map import GridMap, GridMapError
from tests.support.tables import folded

shapes = st.tuples(st.integers(1, 7), st.integers(1, 7))
trinary = arrays(np.int8, shapes, elements=st.sampled_from([-1, 0, 100]))
number = st.floats(-1e6, 1e6)
names = st.text(st.characters(codec="ascii", min_codepoint=32, exclude_characters="\"'\\\x7f"), min_size=1, max_size=12)
descriptions = st.builds(
    MapDescription,
    image=names,
    resolution=st.floats(1e-6, 10.0),
    origin=st.tuples(number, number, number),
    negate=st.booleans(),
    occupied_thresh=st.floats(0.5, 1.0),
    free_thresh=st.floats(0.0, 0.4),
    mode=st.sampled_from(["trinary", "scale", "raw"]),
)
YAML = """# a map
image: testmap.pgm   # beside this file
resolution: 0.1
origin: [2.0, 3.0, 1.0]
negate: 0
occupied_thresh: 0.65
free_thresh: 0.196
"""


@given(st.integers(1, 65535), st.integers(0, 2**32 - 1), st.sampled_from(["P2", "P5"]))
def test_images_there_and_back(max_value: int, seed: int, kind: Any) -> None:
    rng = np.random.default_rng(seed)
    image = GreyImage(rng.integers(0, max_value + 1, rng.integers(1, 9, 2)), max_value)
    again = read_pgm(write_pgm(image, kind, "a comment # of sorts"))
    assert np.array_equal(again.pixels, image.pixels)
    assert again.max_value == max_value
    if kind == "P2":
        assert max(map(len, write_pgm(image, kind).splitlines())) <= 70


@pytest.mark.parametrize("kind", ["P2", "P5"])
@pytest.mark.parametrize("max_value", [255, 65535])
def test_pillow_reads_the_same(kind: Any, max_value: int) -> None:
    pillow = pytest.importorskip("PIL.Image")
    pixels = np.random.default_rng(3).integers(0, max_value + 1, (5, 7))
    with pillow.open(io.BytesIO(write_pgm(GreyImage(pixels, max_value), kind, "made here"))) as seen:
        assert np.array_equal(np.asarray(seen), pixels)
    if kind == "P5":
        saved = io.BytesIO()
        pillow.fromarray(pixels.astype(np.uint8 if max_value == 255 else np.uint16)).save(saved, "PPM")
        assert np.array_equal(read_pgm(saved.getvalue()).pixels, pixels)


def test_comments_may_stand_anywhere_in_a_header() -> None:
    expected = [[1, 2], [3, 4]]
    for text in (
        b"P2 2 2 9 1 2 3 4",
        b"P2\n# one\n2 # two\n#three\n\t2\n9\n1 2\n# between\n3 4 # after\n",
        b"P5\n# one\r2 2#two\n9\n\x01\x02\x03\x04",
    ):
        assert read_pgm(text).pixels.tolist() == expected
    assert read_pgm(b"P5 1 1 255\n#").pixels.tolist() == [[35]]
    assert read_pgm(b"P5 2 1 300\n\x01\x2c\x00\x07").pixels.tolist() == [[300, 7]]


@given(st.sampled_from([1, 255, 256, 65535]), st.integers(0, 2**32 - 1), st.sampled_from([b"\n", b"\r\n", b"\r", b" "]))
def test_an_image_is_read_whole_or_refused(max_value: int, seed: int, end: bytes) -> None:
    """Line ends that something rewrote shift no pixel; a byte too many or too few is refused."""
    rng = np.random.default_rng(seed)
    pixels = rng.integers(0, max_value + 1, rng.integers(1, 9, 2))
    pixels[0, 0] = min(10, max_value)
    height, width = pixels.shape
    raster = pixels.astype(">u1" if max_value < 256 else ">u2").tobytes()
    header = end.join([b"P5", f"{width} {height}".encode(), str(max_value).encode(), b""])
    assert np.array_equal(read_pgm(header + raster).pixels, pixels)
    for wrong in (raster[:-1], raster[:-2], raster + b"\n", raster + b"\n\0", raster * 2):
        with pytest.raises(PgmError, match=r"ends|goes on|start"):
            read_pgm(header + wrong)


def test_a_carriage_return_may_be_the_only_white_space_behind_the_header() -> None:
    assert read_pgm(b"P5 2 1 255\r\n\x07").pixels.tolist() == [[10, 7]]
    assert read_pgm(b"P5 2 1 255\r\n\x07\x08").pixels.tolist() == [[7, 8]]
    with pytest.raises(PgmError, match="ends after 1 of its 2 pixels"):
        read_pgm(b"P5\r\n2 1\r\n255\r\n\x07")


def test_line_ends_rewritten_in_a_map_shift_nothing() -> None:
    pixels = bytes([0, 205, 254, 100, 50, 200])
    expected = read_map(YAML, b"P5\n3 2\n255\n" + pixels).values
    assert np.array_equal(read_map(YAML, b"P5\r\n3 2\r\n255\r\n" + pixels).values, expected)
    with pytest.raises(PgmError):  # a 10 among the pixels has been rewritten too
        read_map(YAML, (b"P5\n3 2\n255\n" + bytes([10]) + pixels[1:]).replace(b"\n", b"\r\n"))


@given(trinary, st.tuples(number, number, st.floats(-3, 3)), st.floats(1e-3, 5.0), st.sampled_from(["trinary", "raw"]))
def test_maps_there_and_back(values: np.ndarray, corner: Any, resolution: float, mode: Any) -> None:
    files = write_map(OccupancyGrid(values, resolution, np.array(corner)), "a map.pgm", mode)
    again = read_map(files.yaml, files.pgm)
    assert np.array_equal(again.values, values)
    assert again.resolution == resolution
    assert tuple(again.T_world_map) == corner


@pytest.mark.parametrize("mode", ["raw", "scale"])
def test_every_value_comes_back(mode: Any) -> None:
    values = np.arange(0 if mode == "scale" else -1, 101, dtype=np.int8)[None]
    files = write_map(OccupancyGrid(values, 0.05, np.zeros(3)), mode=mode)
    assert np.array_equal(read_map(files.yaml, files.pgm).values, values)


@given(trinary)
def test_grid_maps_there_and_back(values: np.ndarray) -> None:
    grid_map = GridMap(values == 0, values == 100, 0.1, np.array([1.0, 2.0, 0.5]))
    files = write_map(OccupancyGrid.from_grid_map(grid_map))
    again = read_map(files.yaml, files.pgm).to_grid_map()
    assert np.array_equal(again.free, grid_map.free)
    assert np.array_equal(again.occupied, grid_map.occupied)
    assert np.array_equal(again.T_world_map, grid_map.T_world_map)


def test_the_top_of_an_image_is_the_far_side_of_the_map() -> None:
    grid = read_map(YAML, write_pgm(GreyImage(np.array([[0, 254], [205, 254], [254, 254]]))))
    assert grid.values.tolist() == [[0, 0], [-1, 0], [100, 0]]
    corner = grid.to_grid_map().to_world([0.0, 3.0])
    assert corner == pytest.approx([2.0 - 0.3 * math.sin(1.0), 3.0 + 0.3 * math.cos(1.0)])


@pytest.mark.parametrize("negate", [False, True])
@pytest.mark.parametrize("mode", ["trinary", "scale", "raw"])
def test_every_shade_is_read_as_the_format_says(mode: Any, negate: bool) -> None:
    described = MapDescription("m.pgm", 1.0, (0.0, 0.0, 0.0), negate, 0.7, 0.3, mode)
    image = GreyImage(np.arange(256)[None])
    found = read_map(write_description(described), write_pgm(image)).values[0]
    for shade in range(256):
        occ = shade / 255 if negate else 1 - shade / 255
        if mode == "raw":
            expected = shade if shade <= 100 else -1
        elif occ > 0.7 or occ < 0.3:
            expected = 100 if occ > 0.7 else 0
        else:
            expected = -1 if mode == "trinary" else round((occ - 0.3) / 0.4 * 100)
        assert found[shade] == expected


def test_a_threshold_belongs_to_what_is_unknown() -> None:
    """occ = 0.5 exactly, with 0.5 for threshold: neither above nor below."""
    image = write_pgm(GreyImage(np.array([[1]]), 2))
    for entries in ("occupied_thresh: 0.5\nfree_thresh: 0.1", "occupied_thresh: 0.9\nfree_thresh: 0.5"):
        text = "image: m.pgm\nresolution: 1\norigin: [0, 0, 0]\n" + entries
        assert read_map(text, image).values.tolist() == [[-1]]


@given(descriptions)
def test_descriptions_there_and_back(description: MapDescription) -> None:
    assert read_description(write_description(description)) == description


@given(descriptions)
def test_another_reader_understands_the_same(description: MapDescription) -> None:
    yaml = pytest.importorskip("yaml")
    seen = yaml.safe_load(write_description(description))
    seen["origin"], seen["negate"] = tuple(seen["origin"]), bool(seen["negate"])
    assert MapDescription(**seen) == description
    seen |= {"image": "maps/my map-2.pgm", "origin": list(seen["origin"])}
    for lists_in_brackets in (None, False):
        theirs = yaml.safe_dump(seen, default_flow_style=lists_in_brackets)
        assert read_description(theirs) == replace(description, image="maps/my map-2.pgm")


@pytest.mark.parametrize(
    "text",
    [
        YAML,
        "image: 'testmap.pgm'\r\nresolution:   0.1\r\norigin:\r\n- 2.0\r\n- 3.0 # y\r\n- 1\r\nnegate: false\r\n",
        '---\nimage: "testmap.pgm"\nmode: Trinary\nextra: some words\nresolution: 1.0e-1\norigin: [2, 3., 1]',
    ],
)
def test_descriptions_as_they_are_met(text: str) -> None:
    assert read_description(text) == MapDescription("testmap.pgm", 0.1, (2.0, 3.0, 1.0))


def test_the_map_of_the_turtlebot(dataset: Callable[[str], bytes]) -> None:
    yaml, pgm = dataset("mcl/turtlebot3_map.yaml").decode(), dataset("mcl/turtlebot3_map.pgm")
    grid = read_map(yaml, pgm)
    assert grid.values.shape == (384, 384)
    assert (grid.resolution, grid.T_world_map.tolist()) == (0.05, [-10.0, -10.0, 0.0])
    counts = {value: int(np.count_nonzero(grid.values == value)) for value in (-1, 0, 100)}
    assert sum(counts.values()) == 384 * 384
    assert min(counts.values()) > 500
    place = grid.to_grid_map()
    assert place.is_free([-2.0, -0.5])
    ranges = place.cast_scans([[-2.0, -0.5, 0.0]], np.linspace(0, 6, 60), 3.5)
    assert np.all((ranges > 0.1) & (ranges <= 3.5))
    again = write_map(grid)
    assert np.array_equal(read_pgm(again.pgm).pixels, read_pgm(pgm).pixels)
    assert np.array_equal(read_map(again.yaml, again.pgm).values, grid.values)


ONE = OccupancyGrid(np.array([[0, 100]]), 1.0, np.zeros(3))


@folded(
    ("argument", "call"),
    [
        ("data", lambda: read_pgm(b"P6 1 1 255\n\x00\x00\x00")),
        ("data", lambda: read_pgm(b"P5 0 1 255\n")),
        ("data", lambda: read_pgm(b"P5 99999 99999 255\n")),
        ("data", lambda: read_pgm(b"P5 1 1 0\n\x00")),
        ("data", lambda: read_pgm(b"P5 1 1 65536\n\x00\x00")),
        ("data", lambda: read_pgm(b"P5 2 1 255\n\x00")),
        ("data", lambda: read_pgm(b"P5 1 1 100\n\x65")),
        ("data", lambda: read_pgm(b"P2 2 1 255\n7")),
        ("data", lambda: read_pgm(b"P2 2 1 255\n7 8 9")),
        ("data", lambda: read_pgm(b"P5 1 1 255\n\x07\n")),
        ("data", lambda: read_pgm(b"P5 1 1 255 # shades\n\x07")),
        ("data", lambda: read_pgm(b"P2 2 1 255\n7 -1")),
        ("data", lambda: read_pgm(b"P2 1 1 255\n256")),
        ("pixels", lambda: GreyImage(np.array([[0.5]]))),  # type: ignore[arg-type]
        ("pixels", lambda: GreyImage(np.array([[256]]))),
        ("max_value", lambda: GreyImage(np.array([[0]]), 70000)),
        ("kind", lambda: write_pgm(GreyImage(np.array([[0]])), "P4")),  # type: ignore[arg-type]
        ("comment", lambda: write_pgm(GreyImage(np.array([[0]])), comment="a\nb")),
        ("values", lambda: OccupancyGrid(np.array([[101]]), 1.0, np.zeros(3))),
        ("values", lambda: OccupancyGrid(np.array([[0.5]]), 1.0, np.zeros(3))),  # type: ignore[arg-type]
        ("resolution", lambda: OccupancyGrid(np.array([[0]]), 0.0, np.zeros(3))),
        ("free_below", lambda: ONE.to_grid_map(70, 60)),
        ("values", lambda: write_map(OccupancyGrid(np.array([[7]]), 1.0, np.zeros(3)))),
        ("values", lambda: write_map(OccupancyGrid(np.array([[-1]]), 1.0, np.zeros(3)), mode="scale")),
        ("mode", lambda: write_map(ONE, mode="colour")),  # type: ignore[arg-type]
        ("image", lambda: write_map(ONE, "")),
        ("yaml", lambda: read_description(YAML + "deeper:\n  key: 1\n")),
        ("yaml", lambda: read_description(YAML + "anchor: &a 1\n")),
        ("yaml", lambda: read_description(YAML + "just words\n")),
        ("yaml", lambda: read_description(YAML + "a: b: c\n")),
        ("negate", lambda: read_description(YAML + "negate: 1\n")),
        ("negate", lambda: read_description(YAML.replace("negate: 0", "negate: 2"))),
        ("mode", lambda: read_description(YAML + "mode: colour\n")),
        ("origin", lambda: read_description(YAML.replace(", 1.0]", "]"))),
        ("origin", lambda: read_description(YAML.replace("2.0", "nan"))),
        ("origin", lambda: read_description(YAML.replace("[2.0, 3.0, 1.0]", "0"))),
        ("resolution", lambda: read_description(YAML.replace("0.1\n", "small\n", 1))),
        ("resolution", lambda: read_description(YAML.replace("0.1\n", "-1\n", 1))),
        ("image", lambda: read_description("resolution: 1\norigin: [0, 0, 0]")),
        ("free_thresh", lambda: read_description(YAML.replace("0.196", "0.9"))),
    ],
)
def test_what_is_no_map_is_named(argument: str, call: Any) -> None:
    with pytest.raises((PgmError, MapFileError, GridMapError)) as error:
        call()
    assert error.value.argument == argument
