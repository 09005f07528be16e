"""Grey images in the PGM format, in memory: P2 (numbers as text) and P5 (bytes), up to 65535 shades.

Source: the Netpbm project, pgm(5): a header of magic number, width, height and largest value, separated by white space,
with comments from # to the end of the line; then, after a single white space for P5, the rows from the top down. Values
above 255 take two bytes each, the most significant one first.

A file holds one image, and nothing behind it: what does not add up is refused. Where git or a transfer as text has
turned line ends into CR LF, the header's last one counts as the single white space.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from reference.errors import InvalidArgumentError, check_choice
from reference.text import decode_and_normalize

Kind = Literal["P2", "P5"]

MAX_PIXELS = 2**28
LINE_OF_TEXT = 70

_BETWEEN = rb"(?:[ \t\n\v\f\r]|#[^\n\r]*[\n\r])+"
_HEADER = re.compile(
    rb"P([25])"
    + _BETWEEN
    + rb"(\d{1,9})"
    + _BETWEEN
    + rb"(\d{1,9})"
    + _BETWEEN
    + rb"(\d{1,5})(?:#[^\n\r]*)?[ \t\n\v\f\r]"
)
_COMMENT = re.compile(rb"#[^\n\r]*")


class PgmError(InvalidArgumentError):
    """Bytes that are no PGM image, or an image that PGM cannot hold; `argument` names it."""


@dataclass(frozen=True, eq=False)
class GreyImage:
    """`pixels` (H, W), from 0 (black) to `max_value` (white); row 0 is the top one. Raises PgmError."""

    pixels: NDArray[np.integer[Any]]
    max_value: int = 255

    def __post_init__(self) -> None:
        values = np.asarray(self.pixels)
        if values.ndim != 2 or values.size == 0 or not np.issubdtype(values.dtype, np.integer):
            raise PgmError("pixels", f"of shape {values.shape} and type {values.dtype} are not whole numbers (H, W)")
        if not 1 <= self.max_value <= 65535:
            raise PgmError("max_value", f"{self.max_value} is not from 1 to 65535")
        if values.min() < 0 or values.max() > self.max_value:
            raise PgmError("pixels", f"hold a value that is not from 0 to {self.max_value}")
        object.__setattr__(self, "pixels", values.astype(np.uint16))


def read_pgm(data: bytes) -> GreyImage:
    """The image of a PGM file, and the whole of it. Raises PgmError, also for bytes behind the image."""
    data = _decode_unicode_p2(bytes(data))
    header = _HEADER.match(data)
    if header is None:
        raise PgmError("data", "does not start with P2 or P5, width, height and largest value")
    width, height, max_value = (int(header.group(k)) for k in (2, 3, 4))
    if not 0 < width * height <= MAX_PIXELS:
        raise PgmError("data", f"announces {width} x {height} pixels: none, or too many")
    if not 1 <= max_value <= 65535:
        raise PgmError("data", f"announces a largest value of {max_value}, not from 1 to 65535")
    body = data[header.end() :]
    if header.group(1) == b"2":
        pixels = _parse_plain_pixels(body, width * height)
    else:
        pixels = _parse_raw_pixels(
            _strip_header_line_feed(header.group(), body, width * height, max_value), width * height, max_value
        )
    if pixels.max() > max_value:
        raise PgmError("data", f"holds a pixel above its largest value, {max_value}")
    return GreyImage(pixels.reshape(height, width), max_value)


def write_pgm(image: GreyImage, kind: Kind = "P5", comment: str = "") -> bytes:
    """The PGM file of an image, with one line of comment or none. Raises PgmError."""
    check_choice("kind", kind, Kind, PgmError)
    if "\n" in comment or "\r" in comment:
        raise PgmError("comment", "has several lines")
    height, width = image.pixels.shape
    note = f"# {comment}\n" if comment else ""
    head = f"{kind}\n{note}{width} {height}\n{image.max_value}\n".encode()
    if kind == "P5":
        return head + image.pixels.astype(_pixel_dtype(image.max_value)).tobytes()
    return head + _format_plain_pixels(image)


def _decode_unicode_p2(data: bytes) -> bytes:
    """Return the ASCII of a P2 image that was saved as Unicode, and other bytes as they are."""
    if data.startswith((b"P2", b"P5")):
        return data
    text = decode_and_normalize(data, "data", PgmError)
    return text.encode() if text.startswith("P2") else data


def _strip_header_line_feed(header: bytes, body: bytes, count: int, max_value: int) -> bytes:
    """Return the bytes of the pixels: without a line feed that ends the header's last line together with its CR.

    It is one where other lines of the header end with CR LF; in a header of one line, where there is one byte too many.
    """
    if not (header.endswith(b"\r") and body.startswith(b"\n")):
        return body
    too_long = len(body) == count * _pixel_dtype(max_value).itemsize + 1
    one_line = b"\n" not in header and b"\r" not in header[:-1]
    return body[1:] if b"\r\n" in header or (one_line and too_long) else body


def _pixel_dtype(max_value: int) -> np.dtype[Any]:
    return np.dtype(">u1" if max_value < 256 else ">u2")


def _parse_plain_pixels(body: bytes, count: int) -> NDArray[np.int64]:
    words = _COMMENT.sub(b"", body).split()
    if len(words) < count:
        raise PgmError("data", f"ends after {len(words)} of its {count} pixels")
    if len(words) > count:
        raise PgmError("data", f"goes on after its {count} pixels")
    if not all(word.isdigit() and len(word) <= 9 for word in words):
        raise PgmError("data", "holds a pixel that is not a whole number")
    return np.array([int(word) for word in words], dtype=np.int64)


def _parse_raw_pixels(body: bytes, count: int, max_value: int) -> NDArray[np.int64]:
    kind = _pixel_dtype(max_value)
    if len(body) < count * kind.itemsize:
        raise PgmError("data", f"ends after {len(body) // kind.itemsize} of its {count} pixels")
    if len(body) > count * kind.itemsize:
        raise PgmError("data", f"goes on after its {count} pixels, by {len(body) - count * kind.itemsize} bytes")
    return np.frombuffer(body, dtype=kind).astype(np.int64)


def _format_plain_pixels(image: GreyImage) -> bytes:
    """The pixels in decimal, in lines of at most 70 characters as the format asks."""
    longest = len(str(image.max_value)) + 1
    each = LINE_OF_TEXT // longest
    values = image.pixels.ravel().tolist()
    lines = (" ".join(map(str, values[k : k + each])) for k in range(0, len(values), each))
    return ("\n".join(lines) + "\n").encode()
