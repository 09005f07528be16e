"""The encoding of a list, judged by what comes out of it, and the repair of accents that an earlier program damaged.

A file of single bytes does not tell its encoding: each one is tried, and French names decide. A file in UTF-8 may hold
accents that were damaged before (« ChloÃ© », « ChloŽ »): they are repaired where one reading alone makes sense, and
what stays damaged is told with its line (`find_damaged_word`).
"""

from __future__ import annotations

import codecs
import itertools
import re
import unicodedata
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache

from server.base.errors import Invalid

#: Encodings of single bytes, the likeliest first, as a teacher knows them.
ENCODINGS: Mapping[str, str] = {
    "cp1252": "Windows", "iso8859_15": "ISO 8859-15", "mac_roman": "Mac", "cp850": "MS-DOS",
}  # fmt: skip
AS_IS = "utf-8"
MARKS = (
    (codecs.BOM_UTF8, "utf-8-sig"), (codecs.BOM_UTF32_LE, "utf-32"), (codecs.BOM_UTF32_BE, "utf-32"),
    (codecs.BOM_UTF16_LE, "utf-16"), (codecs.BOM_UTF16_BE, "utf-16"),
)  # fmt: skip
NOT_TEXT = (
    "Ce fichier n’est pas un texte lisible : ni UTF-8, ni UTF-16, ni Windows, ni Mac, ni MS-DOS. Enregistrez-le en "
    "CSV, en XLSX ou en ODS."
)
UNKNOWN_ENCODING = "L’encodage « {name} » n’est pas proposé : utf-8, utf-16, cp1252, iso8859_15, mac_roman ou cp850."
SCANNED = 200_000  # characters that are judged
DOUBT, USUAL = 3.0, 1.5  # points between two readings that may both be right; of Windows before any other

#: How often letters stand in French names, roughly; other Latin letters are possible, and weigh one.
WEIGHTS = {
    **dict.fromkeys("éÉ", 5.0), **dict.fromkeys("èÈ", 4.0), **dict.fromkeys("çÇëËïÏ", 3.0),
    **dict.fromkeys("êÊôÔîÎâÂöÖüÜàÀœŒñÑ’", 2.0), **dict.fromkeys("«» °", 0.5), **dict.fromkeys("æÆõÕþÞðÐ", 0.1),
}  # fmt: skip
IMPOSSIBLE, WRONG_CASE = -10.0, -6.0
#: Signs that stand in a word only where an encoding was taken for another.
SYMBOLS = frozenset("‚ƒ„…†‡ˆ‰‹•˜™›¡¢£¤¥¦§¨©¬®¯±²³µ¶¸¹¼½¾¿×÷€√∂∑∏π∫Ω≈∆◊ﬁﬂ˘˙˚˛˝ˇı≤≥∞≠⁄░▒▓│┤╣║╗╝┐└┴┬├─┼╚╔╩╦╠═╬┘┌█▄▀■‗")
#: Quotes that people type for an apostrophe, and the short words before one.
APOSTROPHES, ELIDED = "‘´", re.compile(r"(?:\w|qu|jusqu)", re.IGNORECASE)
#: Before a capital within a name: McDonald, DeWitt.
JOINED = re.compile(r"(?:mc|mac|o|d|l|de|du|la|le|st|van|von|fitz|saint|ben|el|al)", re.IGNORECASE)
#: Characters of a word that are judged, and words with accents of a list that are repaired: more than names have.
LONGEST_WORD, MAX_REPAIRED = 80, 8_000
WORD = re.compile(r"\S+")
#: Letters whose two or three bytes of UTF-8 are looked for where they were read as single bytes.
REPAIRED = re.compile("[\u00a0-\u017f\u0218-\u021b\u0300-\u036f\u2010-\u2026\u20ac]+")


@dataclass(frozen=True)
class DecodedText:
    """A text with its encoding. `others`: encodings that may be right too; `repaired`: damaged words, mended."""

    text: str
    encoding: str
    others: tuple[str, ...] = ()
    repaired: tuple[tuple[str, str], ...] = ()


def decode_text(content: bytes, encoding: str | None = None) -> DecodedText:
    """Decode a list. `encoding` is one that somebody chose, and is not judged. Raises Invalid."""
    if encoding:
        return DecodedText(_decode_as(content, encoding), encoding)
    marked = next((name for mark, name in MARKS if content.startswith(mark)), None) or _detect_unmarked_utf16(content)
    for candidate in [marked] if marked else ["utf-8"]:
        text = _decode_or_none(content, candidate)
        if text is not None:
            return _repair_text(text, candidate.removesuffix("-sig"))
    if not marked and (mixed := _decode_mixed(content)):
        return mixed
    readings = (
        {name: _decode_single_bytes(content, name) for name in ENCODINGS} if not marked and b"\0" not in content else {}
    )
    scores = {name: score_accent_plausibility(text) + USUAL * (name == "cp1252") for name, text in readings.items()}
    if not scores or max(scores.values()) <= IMPOSSIBLE * 3:
        raise Invalid(NOT_TEXT)
    best = max(scores, key=lambda name: scores[name])
    if _has_control_characters(readings[best]):
        raise Invalid(NOT_TEXT)
    others = tuple(
        name
        for name in ENCODINGS
        if scores[best] - scores[name] < DOUBT
        and readings[name] != readings[best]
        and not _has_control_characters(readings[name])
    )
    return DecodedText(readings[best], best, others)


def _decode_mixed(content: bytes) -> DecodedText | None:
    """Decode lines in UTF-8 among lines in single bytes, as of two files put together; None where no line is in UTF-8.

    A line of single bytes with an accented letter is UTF-8 by a rare accident only.
    """
    lines = content.split(b"\n")
    decoded = {line: _decode_or_none(line, AS_IS) for line in lines if not line.isascii()}
    others = b"\n".join(line for line, text in decoded.items() if text is None)
    if b"\0" in content or not any(decoded.values()):
        return None
    encoding = decode_text(others).encoding
    text = "\n".join(decoded.get(line) or _decode_single_bytes(line, encoding) for line in lines)
    return _repair_text(text, AS_IS)


def redecode(text: str, read_as: str, encoding: str) -> str:
    """Return a text that was read in one encoding of single bytes as another one reads it. Raises Invalid."""
    if read_as not in ENCODINGS:
        return text
    return _decode_as(bytes(_encode_single_byte(sign, read_as) for sign in text), encoding)


def _decode_as(content: bytes, encoding: str) -> str:
    if encoding not in {*ENCODINGS, AS_IS, "utf-16"}:
        raise Invalid(UNKNOWN_ENCODING.format(name=encoding[:20]))
    text = (
        _decode_single_bytes(content, encoding)
        if encoding in ENCODINGS
        else _decode_or_none(content, _encoding_of_byte_order_mark(content, encoding))
    )
    if text is None or "\0" in text:
        raise Invalid(NOT_TEXT)
    return text


def _encoding_of_byte_order_mark(content: bytes, encoding: str) -> str:
    return next((name for mark, name in MARKS if content.startswith(mark)), encoding)


def _decode_or_none(content: bytes, encoding: str) -> str | None:
    try:
        text = content.decode(encoding)
    except UnicodeDecodeError:
        return None
    return None if "\0" in text else text


def _detect_unmarked_utf16(content: bytes) -> str | None:
    """Return the order of bytes of UTF-16 without a mark: every other byte of Latin letters is zero."""
    sample = content[:2000]
    half = len(sample) // 2
    if half < 2 or len(content) % 2:
        return None
    if sample[1::2].count(0) > half * 0.7 and not sample[0::2].count(0):
        return "utf-16-le"
    return "utf-16-be" if sample[0::2].count(0) > half * 0.7 and not sample[1::2].count(0) else None


def _decode_single_bytes(content: bytes, encoding: str) -> str:
    """Decode single bytes; those that mean nothing become controls, which are never right."""
    if encoding != "cp1252":
        return content.decode(encoding)
    return content.decode("cp1252", errors="surrogateescape").translate(_UNDEFINED)


_UNDEFINED = {0xDC00 + byte: byte for byte in (0x81, 0x8D, 0x8F, 0x90, 0x9D)}


def _has_control_characters(text: str) -> bool:
    return any(sign < " " and sign not in "\t\n\r\x0b\x0c\x1c\x1d\x1e\x1f" for sign in text) or bool(
        re.search("[\x7f-\x9f]", text)
    )


def score_accent_plausibility(text: str) -> float:
    """Score a text: the more of its accented letters stand where French names have them, the higher."""
    return sum(_score_word_plausibility(word) for word in WORD.findall(text[:SCANNED]) if not word.isascii())


@lru_cache(maxsize=8192)
def _score_word_plausibility(word: str) -> float:
    total, word = 0.0, word[:LONGEST_WORD]
    for place, sign in enumerate(word):
        if sign.isascii():
            continue
        if unicodedata.category(sign) in {"Cc", "Co", "Cn", "Cs"} or sign == "\ufffd":
            total += IMPOSSIBLE
        elif not _can_sign_stand_at(word, place):
            total += WRONG_CASE
        elif place == 0 and sign.islower():
            continue  # a name begins with a capital
        else:
            total += WEIGHTS.get(sign, 0.5 if sign.isalpha() and "LATIN" in unicodedata.name(sign, "") else 0.0)
    return total


def _can_sign_stand_at(word: str, place: int) -> bool:
    """Whether the sign at this place of a word can stand there."""
    sign, before, after = word[place], word[place - 1 : place], word[place + 1 : place + 2]
    if sign.isalpha() and sign not in SYMBOLS:
        return _has_plausible_case_at(word, place)
    if sign in SYMBOLS:
        return not (before.isalpha() or after.isalpha())
    if sign in APOSTROPHES:
        return not before.isalpha() or bool(after.isalpha() and ELIDED.fullmatch(_letters_before(word, place)))
    if sign in "«»“”":
        return not (before.isalpha() if sign in "«“" else after.isalpha())
    return sign not in "–—" or not (before.isalpha() and after.isalpha())


def _has_plausible_case_at(word: str, place: int) -> bool:
    """Whether a letter has the case of its neighbours, but for Mc and its like."""
    letter, before, rest = word[place], word[place - 1 : place], word[place + 1 :]
    if letter in "ŽŠŸ" and before.isalpha() and rest[:1].islower():
        return False
    if letter.isupper():
        return not before.islower() or bool(JOINED.fullmatch(_letters_before(word, place)))
    letters = re.match(r"[^\W\d_]*", rest)
    following = letters[0] if letters else ""
    if letter.islower() and before.isupper():
        return not ((len(following) > 1 or place > 1) and (following or word[:place]).isupper())
    return not letter.islower() or not rest[:1].isupper() or not rest.isupper() or len(rest) < 2


def _letters_before(word: str, place: int) -> str:
    start = place
    while start and word[start - 1].isalpha():
        start -= 1
    return word[start:place]


def find_damaged_word(text: str) -> str:
    """Return the first word whose accents were damaged by a wrong encoding, or an empty text."""
    return next((word for word in WORD.findall(text) if is_damaged_word(word)), "")


def is_damaged_word(word: str) -> bool:
    if word.isascii():
        return False
    if len(word) > LONGEST_WORD:
        return "\ufffd" in word or _has_control_characters(word)
    return (
        "\ufffd" in word
        or _has_control_characters(word)
        or _undo_misread_utf8(word) != word
        or any(not sign.isascii() and not _can_sign_stand_at(word, place) for place, sign in enumerate(word))
    )


def _repair_text(text: str, encoding: str) -> DecodedText:
    """Repair damaged words of a text in UTF-8 or UTF-16."""
    repaired: dict[str, str] = {}
    judged = itertools.count()

    def replace(match: re.Match[str]) -> str:
        word = match[0]
        if word.isascii() or len(word) > LONGEST_WORD or next(judged) >= MAX_REPAIRED or not is_damaged_word(word):
            return word
        better = repair_word(word)
        if better != word and len(repaired) < 1000:
            repaired[word] = better
        return better

    return DecodedText(re.sub(r"[^\s;,|\"]+(?:\xa0[^\s;,|\"]+)*", replace, text), encoding, (), tuple(repaired.items()))


@lru_cache(maxsize=4096)
def repair_word(word: str) -> str:
    """Return a damaged word as it was, or the same word where no reading, or more than one, makes sense."""
    fixed = _undo_misread_utf8(word)
    if fixed != word and not is_damaged_word(fixed):
        return fixed
    candidates = {
        candidate
        for read_as in ENCODINGS
        for really in ENCODINGS
        if really != read_as
        and (candidate := _redecode_word(fixed, read_as, really))
        and not is_damaged_word(candidate)
    }
    ranked = sorted(candidates, key=_score_word_plausibility, reverse=True)
    if not ranked or (
        len(ranked) > 1 and _score_word_plausibility(ranked[0]) - _score_word_plausibility(ranked[1]) < DOUBT
    ):
        return word
    return ranked[0]


def _redecode_word(word: str, read_as: str, really: str) -> str:
    try:
        return word.encode(read_as).decode(really)
    except UnicodeError:
        return ""


def _undo_misread_utf8(word: str) -> str:
    """Return a word whose letters in UTF-8 were read as single bytes, once or several times, as it was."""
    for _ in range(3):
        fixed = word
        for encoding in ENCODINGS:
            misread = _misread_utf8_pattern(encoding)
            fixed = misread.sub(lambda match, e=encoding: _decode_misread_run(match[0], e), fixed)  # type: ignore[misc]
        if fixed == word:
            break
        word = fixed
    return word


@lru_cache(maxsize=8)
def _misread_utf8_pattern(encoding: str) -> re.Pattern[str]:
    """Match a first byte of two or three in UTF-8, and its followers, as read in this encoding."""

    def signs(first: int, last: int) -> str:
        return "".join(re.escape(sign) for sign in _iter_decoded_bytes(encoding, first, last))

    follower = f"[{signs(0x80, 0xBF)}]"
    return re.compile(f"[{signs(0xC2, 0xDF)}]{follower}|[{signs(0xE1, 0xEF)}]{follower}{{2}}")


def _iter_decoded_bytes(encoding: str, first: int, last: int) -> Iterator[str]:
    for byte in range(first, last + 1):
        yield _decode_single_bytes(bytes([byte]), encoding)


def _decode_misread_run(run: str, encoding: str) -> str:
    raw = bytes(_encode_single_byte(sign, encoding) for sign in run)
    try:
        letter = raw.decode("utf-8")
    except UnicodeDecodeError:
        return run
    return letter if REPAIRED.fullmatch(letter) else run


@lru_cache(maxsize=4096)
def _encode_single_byte(sign: str, encoding: str) -> int:
    return (
        ord(sign) if encoding == "cp1252" and 0x80 <= ord(sign) <= 0x9F else sign.encode(encoding, errors="replace")[0]
    )
