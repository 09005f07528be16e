"""Characters that Python does not know, pasted from a page, a PDF or a word processor; and what to type instead.

Spaces that separate words are replaced by a space, what has no width is erased, signs and quotes get the spelling of
Python. Strings and comments may hold any character: there nothing is blamed. Where one repair of a character leaves
the file unreadable and another one does not, the latter is told.
"""

from __future__ import annotations

import keyword
import unicodedata
import warnings
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import islice

from server.sandbox.piled_marks import has_piled_marks
from server.sandbox.program_text import find_end_of_string, find_or_end

_SPACES = {
    "\u00a0": "une espace insécable",
    "\u1680": "une espace d’ogam",
    "\u2007": "une espace de la largeur d’un chiffre",
    "\u202f": "une espace fine insécable",
    "\u205f": "une espace moyenne de formule",
    "\u3000": "une espace pleine chasse",
} | {chr(code): "une espace typographique" for code in range(0x2000, 0x200B) if code != 0x2007}
_LINE_ENDS = {
    "\u000b": "une tabulation verticale",
    "\u0085": "une fin de ligne d’un autre système",
    "\u2028": "un séparateur de lignes",
    "\u2029": "un séparateur de paragraphes",
}
_ERASED = {
    "\u00ad": "un trait d’union invisible",
    "\u034f": "un joint invisible",
    "\u180e": "un séparateur invisible",
    "\u200b": "une espace sans largeur",
    "\u200c": "un antiliant sans largeur",
    "\u200d": "un liant sans largeur",
    "\u2060": "un joint sans largeur",
    "\ufeff": "une marque d’ordre des octets",
}
# Letters that nobody sees, although Python takes them for parts of a name.
_UNSEEN_LETTERS = "\u115f\u1160\u3164\uffa0"
_SIGNS: dict[str, tuple[str, str]] = {
    # The character, its name, the spelling in Python.
    **dict.fromkeys("\u2010\u2011\u2012\u2013", ("un tiret", "-")),
    **dict.fromkeys("\u2014\u2015", ("un tiret long", "-")),
    **dict.fromkeys("\u2212\ufe63\u207b\u02d7", ("un signe moins de typographie", "-")),
    **dict.fromkeys("\u00d7\u2217\u22c5\u2022\u2715\u2a2f", ("un signe de multiplication", "*")),
    **dict.fromkeys("\u00f7\u2215\u2044", ("un signe de division", "/")),
    **dict.fromkeys("“”„‟″", ("un guillemet de typographie", '"')),
    **dict.fromkeys("«»", ("un guillemet français", '"')),
    **dict.fromkeys("‘’‚‛′´", ("une apostrophe de typographie", "'")),
    "≤": ("le signe « inférieur ou égal »", "<="),
    "⩽": ("le signe « inférieur ou égal »", "<="),
    "≥": ("le signe « supérieur ou égal »", ">="),
    "⩾": ("le signe « supérieur ou égal »", ">="),
    "≠": ("le signe « différent »", "!="),
    "≡": ("le signe « équivalent »", "=="),
    "∈": ("le signe « appartient »", " in "),
    "∉": ("le signe « n’appartient pas »", " not in "),
    "∧": ("le signe « et »", " and "),
    "∨": ("le signe « ou »", " or "),
    "¬": ("le signe « non »", " not "),
    "→": ("une flèche", "->"),
    "←": ("une flèche", "="),
    "…": ("des points de suspension en un caractère", "..."),
    "√": ("une racine carrée", "np.sqrt"),
    "∞": ("l’infini", "np.inf"),
    "½": ("une fraction", "0.5"),
    "¼": ("une fraction", "0.25"),
    "¾": ("une fraction", "0.75"),
}
_EXPONENTS = dict(zip("⁰¹²³⁴⁵⁶⁷⁸⁹", "0123456789", strict=True))
_CLOSING = {"“": "”“", "„": "”“", "”": "”", "«": "»", "‘": "’‘", "’": "’"}
# Letters of other alphabets that look like Latin ones.
_LOOK_ALIKES = dict(
    zip(
        "АВЕЅІЈКМНОРСТУХасеіјорѕухԁԛԝһ" + "ΑΒΕΖΗΙΚΜΝΟΡΤΥΧονι",
        "ABESIJKMHOPCTYXaceijopsyxdqwh" + "ABEZHIKMNOPTYXovi",
        strict=True,
    )
)
#: Files with more characters than this are not tried out, nor are more repairs than that.
_LONGEST_TRIED, _MOST_TRIED, _MOST_FOUND = 20_000, 24, 400
_MOST_TOLD, _MOST_LINES = 5, 6


@dataclass(frozen=True)
class ForeignCharacter:
    """A character that is foreign to Python: its line, counted from 1, its index in the text, what is to replace it."""

    line: int
    index: int
    character: str
    replacement: str


def find_foreign_characters(lines: Sequence[str]) -> list[ForeignCharacter]:
    """Return the characters of a program's lines that Python does not know, outside of strings and comments.

    Each has the replacement that repairs the program, where one does.
    """
    text = "\n".join(lines)
    places = islice(_foreign_places(text), _MOST_FOUND)
    found = [
        ForeignCharacter(text.count("\n", 0, index) + 1, index, text[index], _replacement_candidates(text, index)[0])
        for index in places
    ]
    return _choose_working_replacements(text, found)


def replace_foreign_characters(lines: Sequence[str], found: Iterable[ForeignCharacter]) -> str:
    """Return the text with each of these characters replaced as it is advised."""
    return _replace_in_text("\n".join(lines), found)


def is_readable(text: str) -> bool:
    """Whether Python can parse the text."""
    return _first_syntax_error_position(text) == _READABLE


def describe_foreign_characters(found: Sequence[ForeignCharacter]) -> str:
    """Return the advice in French, a sentence a kind of repair; empty for none."""
    kinds: dict[tuple[str, str], list[int]] = {}
    for foreign in found:
        kinds.setdefault((foreign.character, foreign.replacement), []).append(foreign.line)
    sentences = [
        f"{_line_numbers_in_words(at)}{_replacement_advice(*kind)}" for kind, at in list(kinds.items())[:_MOST_TOLD]
    ]
    return "\n".join(sentences)


def show_foreign_characters(line: str) -> str:
    """Return a line with its unseen characters spelled out, ⟦U+00A0⟧."""
    return "".join(f"⟦{_code_point_text(character)}⟧" if _is_unseen(character) else character for character in line)


def latin_spelling(name: str) -> str | None:
    """Return a name without its unseen characters, its look-alike letters in Latin; None where nothing changes, or
    where marks are piled on a letter."""
    spelled = "".join(_LOOK_ALIKES.get(letter, letter) for letter in name if not _is_unseen(letter))
    if has_piled_marks(name) or has_piled_marks(spelled):
        return None
    spelled = unicodedata.normalize("NFKC", spelled)
    return spelled if spelled != unicodedata.normalize("NFKC", name) else None


def describe_odd_letters(name: str) -> str:
    """Return which letters of a name are not the Latin ones that they look like, in French."""
    odd = [letter for letter in dict.fromkeys(name) if letter in _LOOK_ALIKES or _is_unseen(letter)]
    described = [
        f"un caractère invisible ({_code_point_text(letter)})"
        if _is_unseen(letter)
        else f"« {letter} » {_alphabet_of_letter(letter)}"
        for letter in odd
    ]
    return " et ".join(described)


def _alphabet_of_letter(letter: str) -> str:
    script = "grec" if "GREEK" in unicodedata.name(letter, "") else "cyrillique"
    return f"de l’alphabet {script} ({_code_point_text(letter)})"


def _code_point_text(character: str) -> str:
    return f"U+{ord(character):04X}"


def _is_unseen(character: str) -> bool:
    return (
        character in _SPACES
        or character in _LINE_ENDS
        or character in _ERASED
        or character in _UNSEEN_LETTERS
        or unicodedata.category(character) == "Cf"
        or "\ufe00" <= character <= "\ufe0f"
    )


def _is_foreign(character: str) -> bool:
    """Whether a character cannot stand in a program outside of strings and comments, or has no business there."""
    if character.isascii():
        return character == "\u000b"
    if _is_unseen(character) or character in _SIGNS or character in _EXPONENTS:
        return True
    if "\uff01" <= character <= "\uff5e" or _is_digit(character):
        return True
    return not ("a" + character).isidentifier()


def _is_digit(character: str) -> bool:
    return unicodedata.decimal(character, -1) >= 0


def _foreign_places(text: str) -> Iterator[int]:
    """Yield the indices of foreign characters in code, and the ends of words that look-alike letters made of keywords.

    A string in typographic quotes is one, too: its quotes are foreign, what they hold is not.
    """
    at, end = 0, len(text)
    while at < end:
        character = text[at]
        if character == "#":
            at = find_or_end(text, "\n", at)
        elif character in "\"'":
            at = find_end_of_string(text, at)
        elif character in _CLOSING:
            yield at
            closing = _closing_quote(text, at)
            if closing:
                yield closing
            at = max(at, closing) + 1
        elif character.isidentifier():
            stop = at + 1
            while stop < end and ("a" + text[stop]).isidentifier():
                stop += 1
            word = text[at:stop]
            as_keyword = not word.isascii() and keyword.iskeyword(latin_spelling(word) or "")
            yield from (k for k in range(at, stop) if _is_foreign(text[k]) or (as_keyword and text[k] in _LOOK_ALIKES))
            at = stop
        else:
            if _is_foreign(character):
                yield at
            at += 1


def _closing_quote(text: str, start: int) -> int:
    """Return the index of the quote that closes a typographic one on its line, before any plain string; 0 for none."""
    end = find_or_end(text, "\n", start)
    stop = min(find_or_end(text, sign, start + 1, end) for sign in '"#')
    closing = min(find_or_end(text, sign, start + 1, stop) for sign in _CLOSING[text[start]])
    return closing if closing < stop else 0


def _replacement_candidates(text: str, index: int) -> tuple[str, ...]:
    """Return what may replace a character, the likeliest first."""
    character = text[index]
    if character in _SPACES or character in _LINE_ENDS:
        return (" ", "") if character in _SPACES else ("\n", " ", "")
    if character in _EXPONENTS:
        in_exponent = text[index - 1] in _EXPONENTS if index else False
        return (_EXPONENTS[character] if in_exponent else f"**{_EXPONENTS[character]}", " ", "")
    if character in _SIGNS or character in _LOOK_ALIKES:
        return (_SIGNS[character][1] if character in _SIGNS else _LOOK_ALIKES[character], " ", "")
    plain = unicodedata.normalize("NFKC", character)
    if not _is_unseen(character) and plain.isascii() and plain.isprintable():
        return (plain, "", " ")
    if _is_digit(character):
        return (str(unicodedata.decimal(character)), "", " ")
    return (" ", "") if _separates_keyword_from_name(text, index) else ("", " ")


def _separates_keyword_from_name(text: str, index: int) -> bool:
    """Whether a character without width stands between a keyword and a name, which would become one word."""
    before = text[max(0, index - _LONGEST_WORD) : index].rsplit("\n", 1)[-1]
    after = text[index + 1 : index + 1 + _LONGEST_WORD].split("\n", 1)[0]
    left = before[len(before.rstrip(_WORD)) :]
    right = after[: len(after) - len(after.lstrip(_WORD))]
    return bool(left and right) and (keyword.iskeyword(left) or keyword.iskeyword(right))


#: Characters of a word that is looked at: keywords are shorter.
_LONGEST_WORD = 20
_WORD = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_"


def _replace_in_text(text: str, found: Iterable[ForeignCharacter]) -> str:
    pieces, last = [], 0
    for foreign in found:
        pieces += [text[last : foreign.index], foreign.replacement]
        last = foreign.index + 1
    return "".join(pieces) + text[last:]


_READABLE = (1 << 60, 0)


def _first_syntax_error_position(text: str) -> tuple[int, int]:
    """Return how far Python can read a text: the line and the column of its first syntax error; nowhere where marks are
    piled on a letter."""
    if has_piled_marks(text):
        return (0, 0)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            compile(text, "solution.py", "exec", dont_inherit=True)
    except SyntaxError as error:
        return (error.lineno or 0, error.offset or 0)
    except (ValueError, RecursionError, MemoryError):
        return (0, 0)
    return _READABLE


def _choose_working_replacements(text: str, found: list[ForeignCharacter]) -> list[ForeignCharacter]:
    """Return the characters with the replacements by which Python reads farthest, the first to last."""
    if not found or len(text) > _LONGEST_TRIED:
        return found
    best, tried = _first_syntax_error_position(_replace_in_text(text, found)), 1
    for rank, foreign in enumerate(found):
        for other in _replacement_candidates(text, foreign.index)[1:]:
            if best == _READABLE or tried >= _MOST_TRIED:
                return found
            changed = [*found]
            changed[rank] = ForeignCharacter(foreign.line, foreign.index, foreign.character, other)
            progress, tried = _first_syntax_error_position(_replace_in_text(text, changed)), tried + 1
            if progress > best:
                best, found = progress, changed
    return found


def _line_numbers_in_words(lines: Sequence[int]) -> str:
    different = list(dict.fromkeys(lines))
    shown = ", ".join(map(str, different[:_MOST_LINES])) + (", …" if len(different) > _MOST_LINES else "")
    return f"Ligne{'s' if len(different) > 1 else ''} {shown} : "


def _replacement_advice(character: str, replacement: str) -> str:
    if character in _LOOK_ALIKES:
        what = (
            f"« {character} » est {_alphabet_of_letter(character).replace('de l’alphabet', 'une lettre de l’alphabet')}"
        )
        return f"{what} : retapez la lettre latine « {replacement} »." if replacement else f"{what}, à effacer."
    kind = _SPACES.get(character) or _LINE_ENDS.get(character) or _ERASED.get(character)
    if kind is None and _is_unseen(character):
        kind = "un caractère invisible"
    if kind is not None:
        what = f"{kind} ({_code_point_text(character)})"
    elif character in _SIGNS:
        what = f"« {character} » ({_SIGNS[character][0]}, {_code_point_text(character)})"
    else:
        what = f"le caractère « {character} » ({_code_point_text(character)}), qui n’existe pas en Python,"
    if not replacement:
        return f"{what} est à effacer (copier-coller ?)."
    if replacement == " ":
        return f"{what} est à remplacer par une espace (copier-coller ?)."
    if replacement == "\n":
        return f"{what} est à remplacer par un retour à la ligne (copier-coller ?)."
    root = " : np.sqrt(…)" if character == "√" else ""
    return f"{what} est à remplacer par {replacement.strip()}{root} (copier-coller ?)."
