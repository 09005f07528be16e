"""Pictures of a hostile program: what matplotlib writes comes out the same, anything else does not come out."""

from __future__ import annotations

import io
import struct
import tracemalloc
import zlib

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from PIL import Image

from server.cells import png
from tests.support.tables import folded

SIGNATURE = b"\x89PNG\r\n\x1a\n"


def chunk(kind: bytes, content: bytes = b"") -> bytes:
    return struct.pack(">I4s", len(content), kind) + content + struct.pack(">I", zlib.crc32(kind + content))


def header(width: int = 2, height: int = 2, depth: int = 8, colour: int = 6, *rest: int) -> bytes:
    return chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, depth, colour, *(rest or (0, 0, 0))))


ROWS = b"\0" + bytes(range(8)) + b"\1" + bytes(range(8))
IDAT, IEND = chunk(b"IDAT", zlib.compress(ROWS)), chunk(b"IEND")
GOOD = SIGNATURE + header() + IDAT + IEND


def pixels(data: bytes) -> np.ndarray:
    with Image.open(io.BytesIO(data)) as image:
        return np.asarray(image)


def kinds(data: bytes) -> list[bytes]:
    found, at = [], 8
    while at < len(data):
        length, kind = struct.unpack_from(">I4s", data, at)
        found.append(kind)
        at += 12 + length
    return found


@pytest.mark.parametrize("mode", ["RGB", "RGBA"])
def test_the_pixels_are_the_same_and_all_the_rest_is_ours(mode: str) -> None:
    values = np.random.default_rng(0).integers(0, 256, (40, 30, len(mode)), dtype=np.uint8)
    given = io.BytesIO()
    image = Image.fromarray(values, mode)
    image.save(given, "PNG", dpi=(150, 150), optimize=True)
    made = png.reencode_png(given.getvalue())
    assert (pixels(made) == values).all()
    assert kinds(made) == [b"IHDR", b"IDAT", b"IEND"]


EXTRAS = {
    "text": chunk(b"tEXt", b"Software\0<script>alert(1)</script>"),
    "compressed text": chunk(b"zTXt", b"a\0\0" + zlib.compress(b"x" * 10**6)),
    "international text": chunk(b"iTXt", b"a\0\0\0\0\0<svg onload=alert(1)>"),
    "profile": chunk(b"iCCP", b"x\0\0" + zlib.compress(b"x" * 1000)),
    "position data": chunk(b"eXIf", b"MM\0*"),
    "animation": chunk(b"acTL", struct.pack(">II", 2, 0)) + chunk(b"fcTL", b"\0" * 26),
    "frames": chunk(b"fdAT", b"\0\0\0\1" + zlib.compress(ROWS)),
    "unknown": chunk(b"abCd", b"secret"),
}


@pytest.mark.parametrize("extra", EXTRAS.values(), ids=EXTRAS.keys())
def test_what_is_beside_the_picture_is_left_out(extra: bytes) -> None:
    for data in (SIGNATURE + header() + extra + IDAT + IEND, SIGNATURE + header() + IDAT + extra + IEND):
        assert png.reencode_png(data) == png.reencode_png(GOOD)


def test_data_in_several_pieces_become_one() -> None:
    packed = zlib.compress(ROWS)
    pieces = b"".join(chunk(b"IDAT", packed[i : i + 3]) for i in range(0, len(packed), 3)) + chunk(b"IDAT")
    assert png.reencode_png(SIGNATURE + header() + pieces + IEND) == png.reencode_png(GOOD)


def data(rows: bytes) -> bytes:
    return chunk(b"IDAT", zlib.compress(rows))


HOSTILE = {
    "nothing": b"",
    "signature alone": SIGNATURE,
    "another signature": b"GIF89a" + GOOD,
    "markup": b"<svg xmlns='http://www.w3.org/2000/svg' onload='alert(1)'/>",
    "no header": SIGNATURE + IDAT + IEND,
    "header later": SIGNATURE + chunk(b"tEXt", b"a\0b") + header() + IDAT + IEND,
    "two headers": SIGNATURE + header() + header() + IDAT + IEND,
    "short header": SIGNATURE + chunk(b"IHDR", b"\0" * 12) + IDAT + IEND,
    "no data": SIGNATURE + header() + IEND,
    "no end": SIGNATURE + header() + IDAT,
    "an end that holds something": SIGNATURE + header() + IDAT + chunk(b"IEND", b"x"),
    "bytes after the end": GOOD + b"<script>",
    "a picture after the end": GOOD + GOOD,
    "wrong checksum": GOOD[:40] + bytes([GOOD[40] ^ 1]) + GOOD[41:],
    "wrong checksum of the end": GOOD[:-1] + b"x",
    "cut in the middle": GOOD[:-20],
    "a length that overflows": SIGNATURE + struct.pack(">I4s", 0xFFFFFFFF, b"IHDR") + b"x" * 40,
    "wide": SIGNATURE + header(2**31 - 1, 1) + IDAT + IEND,
    "wider than any": SIGNATURE + header(2**32 - 1, 2**32 - 1) + IDAT + IEND,
    "too many pixels": SIGNATURE + header(2000, 1001) + data(b"\0" * 1001 * 8001) + IEND,
    "empty": SIGNATURE + header(0, 2) + data(b"") + IEND,
    "palette": SIGNATURE + header(colour=3) + chunk(b"PLTE", b"\0" * 6) + data(b"\0\0\1\0\1\0") + IEND,
    "unasked palette": SIGNATURE + header() + chunk(b"PLTE", b"\0" * 6) + IDAT + IEND,
    "sixteen bits": SIGNATURE + header(depth=16) + data(b"\0" * 34) + IEND,
    "unknown colours": SIGNATURE + header(colour=7) + IDAT + IEND,
    "interlaced": SIGNATURE + header(2, 2, 8, 6, 0, 0, 1) + IDAT + IEND,
    "another compression": SIGNATURE + header(2, 2, 8, 6, 1, 0, 0) + IDAT + IEND,
    "unknown filter": SIGNATURE + header() + data(b"\5" + ROWS[1:]) + IEND,
    "a row too few": SIGNATURE + header() + data(ROWS[:9]) + IEND,
    "a byte too many": SIGNATURE + header() + data(ROWS + b"\0") + IEND,
    "no compression": SIGNATURE + header() + chunk(b"IDAT", ROWS) + IEND,
    "a stream cut short": SIGNATURE + header() + chunk(b"IDAT", zlib.compress(ROWS)[:-1]) + IEND,
    "bytes after the stream": SIGNATURE + header() + chunk(b"IDAT", zlib.compress(ROWS) + b"x") + IEND,
    "a stream with a dictionary": SIGNATURE + header() + chunk(b"IDAT", b"\x78\xbb\0\0\0\0x") + IEND,
    "data in two places": SIGNATURE + header() + IDAT + chunk(b"tEXt", b"a\0b") + chunk(b"IDAT") + IEND,
    "unknown critical chunk": SIGNATURE + header() + chunk(b"ABCD") + IDAT + IEND,
    "a kind that is no word": SIGNATURE + header() + chunk(b"a\0b<") + IDAT + IEND,
}  # fmt: skip


@folded("given", HOSTILE.values(), ids=HOSTILE.keys())
def test_anything_out_of_the_ordinary_is_refused(given: bytes) -> None:
    with pytest.raises(png.MalformedPng):
        png.reencode_png(given)


def test_a_bomb_takes_no_more_memory_than_its_header_says() -> None:
    packer = zlib.compressobj(9)
    packed = b"".join(packer.compress(bytes(1 << 20)) for _ in range(48)) + packer.flush()
    bomb = SIGNATURE + header(100, 100) + chunk(b"IDAT", packed) + IEND
    tracemalloc.start()
    try:
        with pytest.raises(png.MalformedPng):
            png.reencode_png(bomb)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert peak < 4 << 20


def test_a_picture_that_does_not_compress_is_refused_above_its_bound() -> None:
    noise = np.random.default_rng(0).integers(0, 256, (1000, 1801), dtype=np.uint8)
    noise[:, 0] = 0
    with pytest.raises(png.MalformedPng):
        png.reencode_png(SIGNATURE + header(450, 1000) + data(noise.tobytes()) + IEND)


@settings(suppress_health_check=[HealthCheck.too_slow])
@given(st.integers(0, len(GOOD) - 1), st.binary(max_size=4), st.integers(0, 8))
def test_whatever_is_changed_it_is_refused_or_a_picture(at: int, inserted: bytes, removed: int) -> None:
    changed = GOOD[:at] + inserted + GOOD[at + removed :]
    try:
        made = png.reencode_png(changed)
    except png.MalformedPng:
        return
    assert pixels(made).shape == (2, 2, 4)
