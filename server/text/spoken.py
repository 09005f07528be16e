"""The accessible text of a piece of HTML: its words, and its formulas as MathML text.

Browsers leave formulas out when they make the name of a control from what stands in its label.
"""

from __future__ import annotations

from html.parser import HTMLParser

#: Of a formula: how it is drawn, and how it was written.
SILENT = {"annotation"}
#: What stands between two rows of a matrix, and two of its coefficients.
BETWEEN = {("mtr", "mtr"): " ; ", ("mtd", "mtd"): ", "}
VOID = {"br", "hr", "img", "input", "wbr"}


def html_to_spoken_text(html: str) -> str:
    """Plain text in one line; empty where the HTML has no formula, and needs no help."""
    if "<math" not in html:
        return ""
    reader = _SpokenMathParser()
    reader.feed(html)
    reader.close()
    return " ".join("".join(reader.said).split())


class _SpokenMathParser(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.said: list[str] = []
        self._silent_depth = 0  # depth of open elements inside a silent one
        self._after = ""  # the tag of a table that has just ended

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag in VOID:
            return
        if self._silent_depth or tag in SILENT or ("aria-hidden", "true") in attrs:
            self._silent_depth += 1
        elif (tag, self._after) in BETWEEN:
            self.said.append(BETWEEN[tag, self._after])
        self._after = ""

    def handle_endtag(self, tag: str) -> None:
        self._after = tag
        if self._silent_depth and tag not in VOID:
            self._silent_depth -= 1

    def handle_data(self, data: str) -> None:
        if not self._silent_depth:
            self.said.append(data)
