"""Grey images in the PGM format, in memory: P2 (numbers as text) and P5 (bytes), up to 65535 shades.

Source: the Netpbm project, pgm(5): a header of magic number, width, height and largest value, separated by white space,
with comments from # to the end of the line; then, after a single white space for P5, the rows from the top down. Values
above 255 take two bytes each, the most significant one first.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from reference.errors import InvalidArgumentError

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
    """The image of a PGM file. What follows a P5 image is left alone. Raises PgmError."""
    header = _HEADER.match(data)
    if header is None:
        raise PgmError("data", "does not start with P2 or P5, width, height and largest value")
    width, height, max_value = (int(header.group(k)) for k in (2, 3, 4))
    if not 0 < width * height <= MAX_PIXELS:
        raise PgmError("data", f"announces {width} x {height} pixels: none, or too many")
    if not 1 <= max_value <= 65535:
        raise PgmError("data", f"announces a largest value of {max_value}, not from 1 to 65535")
    decode = _plain_pixels if header.group(1) == b"2" else _raw_pixels
    pixels = decode(data[header.end() :], width * height, max_value)
    if pixels.max() > max_value:
        raise PgmError("data", f"holds a pixel above its largest value, {max_value}")
    return GreyImage(pixels.reshape(height, width), max_value)


def write_pgm(image: GreyImage, kind: Literal["P2", "P5"] = "P5", comment: str = "") -> bytes:
    """The PGM file of an image, with one line of comment or none. Raises PgmError."""
    if "\n" in comment or "\r" in comment:
        raise PgmError("comment", "has several lines")
    height, width = image.pixels.shape
    note = f"# {comment}\n" if comment else ""
    head = f"{kind}\n{note}{width} {height}\n{image.max_value}\n".encode()
    if kind == "P5":
        return head + image.pixels.astype(">u1" if image.max_value < 256 else ">u2").tobytes()
    if kind == "P2":
        return head + _text(image)
    raise PgmError("kind", f"{kind!r} is not P2 or P5")


def _plain_pixels(body: bytes, count: int, max_value: int) -> NDArray[np.int64]:
    words = _COMMENT.sub(b"", body).split()
    if len(words) < count:
        raise PgmError("data", f"ends after {len(words)} of its {count} pixels")
    if not all(word.isdigit() and len(word) <= 9 for word in words[:count]):
        raise PgmError("data", "holds a pixel that is not a whole number")
    return np.array([int(word) for word in words[:count]], dtype=np.int64)


def _raw_pixels(body: bytes, count: int, max_value: int) -> NDArray[np.int64]:
    kind = np.dtype(">u1" if max_value < 256 else ">u2")
    if len(body) < count * kind.itemsize:
        raise PgmError("data", f"ends after {len(body) // kind.itemsize} of its {count} pixels")
    return np.frombuffer(body, dtype=kind, count=count).astype(np.int64)


def _text(image: GreyImage) -> bytes:
    """The pixels in decimal, in lines of at most 70 characters as the format asks."""
    longest = len(str(image.max_value)) + 1
    each = LINE_OF_TEXT // longest
    values = image.pixels.ravel().tolist()
    lines = (" ".join(map(str, values[k : k + each])) for k in range(0, len(values), each))
    return ("\n".join(lines) + "\n").encode()
