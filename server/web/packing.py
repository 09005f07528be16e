"""Pages of which a long part is the same for all who read: it is compressed once, and what is written for one reader is
put around it.

A stream of gzip may be cut wherever its compressor forgets what came before (`Z_FULL_FLUSH`), so that the parts need
only stand one after the other. What a browser gets is one ordinary member, and its checksum is that of the whole page.
"""

from __future__ import annotations

import secrets
import struct
from dataclasses import dataclass
from functools import lru_cache
from hashlib import sha256

from markupsafe import Markup
from zlib_ng import zlib_ng as zlib

from server.base import root_path

#: Stands in a page where the long part comes. Nobody can write it: it is another one in each process.
PLACE = Markup(f"<!--{secrets.token_hex(16)}-->")
LEVEL, STEADY_LEVEL = 4, 9  # what is compressed for each reader, and what is compressed once
RAW = -zlib.MAX_WBITS
HEAD = b"\x1f\x8b\x08\x00\x00\x00\x00\x00\x00\xff"  # deflated, without a name, a time, or a system
WORD = 0xFFFFFFFF
TAG = 24  # of the digits of a digest: SHA-256, which processors have an instruction for
MOST_KEPT = 512
MOST_CHANGING = 32  # of hundreds of kilobytes


@dataclass(frozen=True)
class Steady:
    """The long part, packed. `crc` is its checksum, and `shift` what a checksum of what stands before it becomes, by
    each of its bits: the checksum of both is linear in it."""

    packed: bytes
    length: int
    digest: bytes
    crc: int
    shift: tuple[int, ...]

    def after(self, crc: int) -> int:
        """The checksum of something that has this one, followed by the part."""
        found = self.crc
        for place, moved in enumerate(self.shift):
            if crc >> place & 1:
                found ^= moved
        return found


def _written(html: str) -> bytes:
    return root_path.with_external_paths(str(html)).encode()  # as plain text: what is put into markup is escaped


def steady(html: str, *, changing: bool = False) -> Steady:
    """Of the HTML of the part, whose addresses are still the service's own. `changing`: it is the same for a while
    alone, and not worth to be compressed longer than what is written for one reader."""
    return _changing(html, root_path.root_path()) if changing else _steady(html, root_path.root_path())


@lru_cache(maxsize=MOST_KEPT)
def _steady(html: str, _root: str) -> Steady:
    return _packed(html, STEADY_LEVEL)


@lru_cache(maxsize=MOST_CHANGING)
def _changing(html: str, _root: str) -> Steady:
    return _packed(html, LEVEL)


def _packed(html: str, level: int) -> Steady:
    content = _written(html)
    packer = zlib.compressobj(level, zlib.DEFLATED, RAW)
    packed = packer.compress(content) + packer.flush(zlib.Z_FULL_FLUSH)
    crc = zlib.crc32(content)
    shift = tuple(zlib.crc32(content, 1 << place) ^ crc for place in range(32))
    return Steady(packed, len(content), sha256(content).digest(), crc, shift)


@dataclass(frozen=True)
class Page:
    """What is sent of a page; `long` is the HTML of its long part, as `steady` wants it, if it has one."""

    before: bytes
    long: str | None = None
    after: bytes = b""
    changing: bool = False

    @property
    def tag(self) -> str:
        """Of its content, whoever compresses it."""
        told = sha256(self.before)
        if self.long is not None:
            told.update(steady(self.long, changing=self.changing).digest)
            told.update(self.after)
        return f'W/"{told.hexdigest()[:TAG]}"'

    @property
    def plain(self) -> bytes:
        return self.before if self.long is None else self.before + _written(self.long) + self.after

    @property
    def packed(self) -> bytes:
        """As gzip."""
        packer = zlib.compressobj(LEVEL, zlib.DEFLATED, RAW)
        if self.long is None:
            body = packer.compress(self.before) + packer.flush()
            return HEAD + body + struct.pack("<II", zlib.crc32(self.before), len(self.before) & WORD)
        part = steady(self.long, changing=self.changing)
        first = packer.compress(self.before) + packer.flush(zlib.Z_FULL_FLUSH)
        last = packer.compress(self.after) + packer.flush()
        crc = zlib.crc32(self.after, part.after(zlib.crc32(self.before)))
        length = len(self.before) + part.length + len(self.after)
        return b"".join((HEAD, first, part.packed, last, struct.pack("<II", crc, length & WORD)))


def page(html: str, long: str, *, changing: bool = False) -> Page:
    """A page as its template wrote it, and what comes in it at `PLACE`, if that stands there."""
    before, place, after = root_path.with_external_paths(html).partition(PLACE)
    return Page(before.encode(), long, after.encode(), changing) if place else Page(before.encode())
