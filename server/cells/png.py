"""Reads the PNG of a hostile program, and writes one of our own that has its pixels and nothing else.

What matplotlib writes is all that is understood: eight bits a sample, RGB with or without transparency, not interlaced.
The compressed data are inflated within a bound that the header gives, checked, and compressed anew: no byte of what was
given is passed on but the samples themselves.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator

SIGNATURE = b"\x89PNG\r\n\x1a\n"
MAX_SIDE, MAX_PIXELS, MAX_BYTES = 8000, 2_000_000, 3 << 19
#: Samples of a pixel, by the colour type of the header.
_SAMPLES = {2: 3, 6: 4}
_FILTERS = 5
_HEADER = struct.Struct(">IIBBBBB")


class MalformedPng(ValueError):
    """These bytes are not a picture that we take."""


def reencode_png(data: bytes) -> bytes:
    """A PNG of the same pixels, made by us. Raises Malformed, and nothing else, for anything out of the ordinary."""
    header, packed = _read_header_and_image_data(data)
    width, height, samples = _parse_header(header)
    rows = _inflate_exactly(packed, height * (1 + width * samples))
    if max(rows[:: 1 + width * samples]) >= _FILTERS:
        raise MalformedPng("unknown filter")
    made = b"".join(
        (
            SIGNATURE,
            _encode_chunk(b"IHDR", header),
            _encode_chunk(b"IDAT", zlib.compress(rows)),
            _encode_chunk(b"IEND", b""),
        )
    )
    if len(made) > MAX_BYTES:
        raise MalformedPng("too many bytes")
    return made


def _read_header_and_image_data(data: bytes) -> tuple[bytes, bytes]:
    """The header, and the compressed data of all its pieces."""
    chunks = _iterate_chunks(data)
    kind, header = next(chunks, (b"", b""))
    if kind != b"IHDR":
        raise MalformedPng("no header")
    pieces, over = [], False
    for kind, content in chunks:
        if kind == b"IDAT":
            if over:
                raise MalformedPng("data in two places")
            pieces.append(content)
        elif kind[0] & 0x20 == 0 and kind != b"IEND":  # a capital letter: not to be left out, and we know no such thing
            raise MalformedPng("unknown critical chunk")
        over = bool(pieces) and kind != b"IDAT"
    if kind != b"IEND" or content:
        raise MalformedPng("no end")
    return header, b"".join(pieces)


def _iterate_chunks(data: bytes) -> Iterator[tuple[bytes, bytes]]:
    """Kind and content of each chunk up to IEND, which must be the last thing there is."""
    if not data.startswith(SIGNATURE):
        raise MalformedPng("no signature")
    at, kind = len(SIGNATURE), b""
    while kind != b"IEND":
        length, kind = struct.unpack_from(">I4s", data, at) if at + 12 <= len(data) else (len(data), b"")
        end = at + 8 + length
        if end + 4 > len(data) or not kind.isalpha():
            raise MalformedPng("cut short")
        content = data[at + 8 : end]
        if struct.unpack_from(">I", data, end)[0] != zlib.crc32(content, zlib.crc32(kind)):
            raise MalformedPng("wrong checksum")
        at = end + 4
        yield kind, content
    if at != len(data):
        raise MalformedPng("bytes left over")


def _parse_header(header: bytes) -> tuple[int, int, int]:
    """Width, height and samples of a pixel."""
    if len(header) != _HEADER.size:
        raise MalformedPng("header of another length")
    width, height, depth, colour, *methods = _HEADER.unpack(header)
    if not (0 < width <= MAX_SIDE and 0 < height <= MAX_SIDE and width * height <= MAX_PIXELS):
        raise MalformedPng("too large, or empty")
    if depth != 8 or colour not in _SAMPLES or any(methods):
        raise MalformedPng("another kind of picture")
    return width, height, _SAMPLES[colour]


def _inflate_exactly(compressed: bytes, size: int) -> bytes:
    """Exactly `size` bytes, of one whole zlib stream that is all there is; never asks for more memory than that."""
    stream = zlib.decompressobj()
    try:
        rows = stream.decompress(compressed, size + 1)
    except zlib.error as error:
        raise MalformedPng("data that do not inflate") from error
    if len(rows) != size or not stream.eof or stream.unused_data or stream.unconsumed_tail:
        raise MalformedPng("data of another length")
    return rows


def _encode_chunk(kind: bytes, content: bytes) -> bytes:
    return struct.pack(">I4s", len(content), kind) + content + struct.pack(">I", zlib.crc32(content, zlib.crc32(kind)))
