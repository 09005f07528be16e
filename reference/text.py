"""Text of a file, whatever saved it: the byte order marks of Unicode, and line ends of three systems.

Notepad and spreadsheets of Windows put a mark at the start of a file, may write two bytes a character, and end lines
with CR LF; the lines of old Macs end with CR. All readers of text formats take their text from here.

Sources: The Unicode Standard, section 23.8 (byte order mark); RFC 3629, section 6 (the mark in UTF-8).
"""

from __future__ import annotations

import codecs

from reference.errors import InvalidArgumentError

MARK = "\ufeff"
#: The mark in UTF-8, read as if it were Windows-1252.
MISREAD_MARK = "ï»¿"
#: UTF-32 comes first: its mark of little end begins with that of UTF-16.
_MARKED = (
    (codecs.BOM_UTF32_LE, "utf-32-le"),
    (codecs.BOM_UTF32_BE, "utf-32-be"),
    (codecs.BOM_UTF8, "utf-8"),
    (codecs.BOM_UTF16_LE, "utf-16-le"),
    (codecs.BOM_UTF16_BE, "utf-16-be"),
)


def decode_and_normalize(
    data: str | bytes, argument: str = "text", error: type[InvalidArgumentError] = InvalidArgumentError
) -> str:
    """Return a file's text, its encoding detected, without byte order marks, its lines ended by a line feed.

    A str loses its marks and other line ends too.
    Bytes with a mark are UTF-8, UTF-16 or UTF-32, as it says; those without are UTF-8, or UTF-16 where every other one
    of the first four is zero, or else Windows-1252. Raises `error` for bytes that are no text in that encoding.
    """
    text = data if isinstance(data, str) else _decode_bytes(bytes(data), argument, error)
    plain = text.replace("\r\n", "\n").replace("\r", "\n").removeprefix(MISREAD_MARK)
    # Files that were put one behind the other have a mark in the middle.
    return plain.removeprefix(MARK).replace("\n" + MARK, "\n")


def decode_lines(
    data: str | bytes, argument: str = "text", error: type[InvalidArgumentError] = InvalidArgumentError
) -> list[str]:
    """Return the lines of `decode_and_normalize(data)`, as an editor counts them: no other character ends a line."""
    lines = decode_and_normalize(data, argument, error).split("\n")
    return lines if lines[-1] else lines[:-1]


def _decode_bytes(data: bytes, argument: str, error: type[InvalidArgumentError]) -> str:
    mark, encoding = next(
        ((mark, name) for mark, name in _MARKED if data.startswith(mark)), (b"", _guess_unmarked_encoding(data))
    )
    body = data[len(mark) :]
    try:
        return body.decode(encoding)
    except UnicodeDecodeError as fault:
        if not mark and encoding == "utf-8" and b"\0" not in body:
            return body.decode("cp1252", "replace")
        line = body[: fault.start].decode(encoding, "replace").count("\n") + 1
        raise error(argument, f"line {line} is no text in {encoding.upper()}") from None


def _guess_unmarked_encoding(data: bytes) -> str:
    """Return the encoding of bytes without a mark: letters and digits have one byte of two that is zero in UTF-16."""
    zeros = [byte == 0 for byte in data[:4]]
    if zeros == [False, True, False, True]:
        return "utf-16-le"
    return "utf-16-be" if zeros == [True, False, True, False] else "utf-8"
