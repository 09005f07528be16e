"""Shapes of text by which a stranger may try to hold up everybody: each makes some reader, somewhere, begin again.

A shape is a function from a size in characters to a text of about that size.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

Shape = Callable[[int], str]


def _repeat(part: str) -> Shape:
    return lambda size: part * (size // len(part))


def _around(before: str, part: str, after: str) -> Shape:
    return lambda size: before + part * (size // len(part)) + after


def _nested(opening: str, closing: str) -> Shape:
    return lambda size: (
        opening * (size // (len(opening) + len(closing))) + closing * (size // (len(opening) + len(closing)))
    )


def _numbered(template: str) -> Shape:
    def make(size: int) -> str:
        length = len(template.format(size))
        return "".join(template.format(number) for number in range(size // length))

    return make


#: What any text may be: a name, a message, a search, a cell, a header, a file.
TEXTS: Mapping[str, Shape] = {
    "one word": _repeat("a"),
    "words": _repeat("alpha "),
    "different words": _numbered("mot{} "),
    "long blanks": _around("match", " ", "x"),
    "tabulations": _around("a", "\t", "b"),
    "no-break spaces": _around("a", "\u00a0", "b"),
    "line ends": _around("a", "\n", "b"),
    "carriage returns": _around("a", "\r", "b"),
    "mixed line ends": _repeat("a\r\nb\rc\n\x0b\x0c\u2028"),
    "blank lines with blanks": _repeat("    \n"),
    "one very long line": _repeat("x = 1; "),
    "many short lines": _repeat("a\n"),
    "digits": _repeat("9"),
    "digits of other scripts": _repeat("\u0669"),
    "underscored digits": _repeat("1_"),
    "exponents": _repeat("1e"),
    "decimals": _repeat("1.1,"),
    "marks on one letter": _around("a", "\u0327\u0301\u0323\u0308", ""),
    "marks between invisible characters": _repeat("\u0327\u0301" * 15 + "\u200b"),
    "opened quotes": _repeat("«"),
    "opened quotes of words": _repeat("“a ‘"),
    "marks on each letter": _repeat("e\u0323\u0302"),
    "composed letters": _repeat("\u1e69"),
    "letters that grow": _repeat("\ufdfa"),
    "ligatures": _repeat("\ufb03"),
    "capitals that grow": _repeat("\u0130ß"),
    "right to left": _repeat("\u202eא"),
    "joined pictures": _repeat("\U0001f468\u200d"),
    "invisible characters": _repeat("\u200b\u2060"),
    "selectors": _repeat("a\ufe0f"),
    "tags": _repeat("\U000e0061"),
    "control characters": _repeat("\x07\x1b"),
    "replaced letters": _repeat("\ufffdÃ©"),
    "hangul": _repeat("\u1100\u1161\u11a8"),
    "open brackets": _repeat("("),
    "nested brackets": _nested("[", "]"),
    "mixed brackets": _repeat("([{"),
    "quotes": _repeat("'"),
    "double quotes": _repeat('"'),
    "quotes and separators": _repeat('";'),
    "backslashes": _repeat("\\"),
    "percents": _repeat("%"),
    "zeros after a percent": _around("'%", "0", ""),
    "percent escapes": _repeat("%C3%A9"),
    "ampersands": _repeat("&"),
    "entities": _repeat("&lt;&#65;"),
    "opened tags": _repeat("<a "),
    "nested tags": _nested("<b>", "</b>"),
    "comments of a page": _repeat("<!--"),
    "commas": _repeat(","),
    "semicolons": _repeat(";"),
    "separators in turn": _repeat(",;\t|"),
    "points": _repeat("."),
    "ats": _repeat("a@"),
    "an address": _around("a@", "a.", "fr"),
    "dashes": _repeat("-"),
    "apostrophes": _repeat("l’"),
    "slashes": _repeat("/"),
    "parent folders": _repeat("../"),
    "colons": _repeat("12:"),
    "dates": _repeat("2026-01-01 "),
    "capitals and words": _repeat("DE LA Fontaine "),
    "pairs": _numbered("a{}=1&"),
    "weights": _repeat("fr;q=0.1,"),
}

#: What Markdown, and the French of a statement, may be.
MARKDOWN: Mapping[str, Shape] = {
    "nested quotes": _repeat("> "),
    "nested lists": lambda size: "".join(" " * 2 * depth + "- a\n" for depth in range(int(size**0.5))),
    "list marks": _repeat("- "),
    "emphasis": _repeat("*a_ "),
    "emphasis in turn": _repeat("*_"),
    "open emphasis": _repeat("a**b"),
    "open links": _repeat("["),
    "links": _repeat("[a]("),
    "images": _repeat("![a]["),
    "references": _numbered("[a{}]: b\n"),
    "backticks": _repeat("`"),
    "backticks of all lengths": lambda size: " ".join("`" * length for length in range(1, int((2 * size) ** 0.5))),
    "fences": _repeat("```\n"),
    "tables": _repeat("|a|b|\n|-|-|\n"),
    "a wide table": lambda size: "|a" * (size // 4) + "|\n" + "|-" * (size // 4) + "|\n",
    "mathematics": _repeat("$a"),
    "blocks of mathematics": _repeat("$$\n"),
    "braces of mathematics": _around("$", "{", "$"),
    "fractions": _around("$", "\\frac{", "$"),
    "titles": _repeat("# a\n"),
    "rules": _repeat("---\n"),
    "autolinks": _repeat("<http://a"),
    "footnotes": _repeat("[^a]"),
}

#: What a program may be, or a call that is typed.
PROGRAMS: Mapping[str, Shape] = {
    "prefixes": _repeat("rb'"),
    "an open long string": _around("'''", "a'", ""),
    "nested formats": _repeat("f'{"),
    "formats": _repeat("'%d' % "),
    "decorators": _repeat("@a\n"),
    "comments": _repeat("# a\n"),
    "many names": _numbered("n{} = 1\n"),
    "many functions": _numbered("def f{}(): pass\n"),
    "nested blocks": lambda size: "".join(" " * depth + "if 1:\n" for depth in range(int((2 * size) ** 0.5))),
    "nested functions": lambda size: "".join(" " * depth + "def f():\n" for depth in range(int((2 * size) ** 0.5))),
    "else after else": lambda size: "if a: b\n" + "elif a: b\n" * (size // 10),
    "nested lambdas": _repeat("lambda:"),
    "nots": _repeat("not "),
    "minus signs": _repeat("-"),
    "a sum": _around("a", "+a", ""),
    "a power": _around("2", "**2", ""),
    "a comparison": _around("a", "<a", ""),
    "attributes": _around("a", ".a", ""),
    "subscripts": _around("a", "[0]", ""),
    "calls": _around("a", "(0)", ""),
    "arguments": _around("f(", "1,", ")"),
    "named arguments": lambda size: f"f({_numbered('a{}=1,')(size)})",
    "a list of lists": _around("[", "[1],", "]"),
    "a table of entries": lambda size: f"{{{_numbered('{}:1,')(size)}}}",
    "strings side by side": _repeat("'a' "),
    "a long number": _around("x = ", "9", ""),
    "a long hexadecimal number": _around("x = 0x", "f", ""),
    "continued lines": _repeat("\\\n"),
    "imports": _repeat("import a\n"),
    "a long name": _around("", "a", " = 1"),
    "characters of elsewhere": _repeat("“”×−"),
    "indents and dedents": _repeat("if a:\n  b\n"),
    "null bytes": _repeat("a\x00"),
}

#: What JSON may be; the last ones are read by pydantic as something else than what is awaited.
JSON: Mapping[str, Shape] = {
    "deep lists": _repeat("["),
    "closed deep lists": _nested("[", "]"),
    "deep objects": _repeat('{"a":'),
    "many keys": lambda size: "{" + _numbered('"k{}":1,')(size) + '"a":1}',
    "the same key": lambda size: "{" + '"a":1,' * (size // 6) + '"a":1}',
    "a huge key": lambda size: '{"' + "k" * size + '":1}',
    "a long number as such": lambda size: "9" * size,
    "a long decimal": lambda size: "0." + "9" * size,
    "a long exponent": lambda size: "1e" + "9" * size,
    "escapes": lambda size: '"' + "\\u00e9" * (size // 6) + '"',
    "surrogates": lambda size: '"' + "\\ud800" * (size // 6) + '"',
    "an open string": lambda size: '"' + "a" * size,
    "many strings": lambda size: "[" + '"a",' * (size // 4) + '"a"]',
    "many nulls": lambda size: "[" + "null," * (size // 5) + "null]",
    "blanks before": lambda size: " " * size + "{}",
    "pairs of a form": lambda size: "[" + '["a","b"],' * (size // 10) + '["a","b"]]',
}
