"""What a piece of a page's HTML says aloud: its words, and its formulas as their MathML reads.

Browsers leave formulas out when they make the name of a control from what stands in its label.
"""

from __future__ import annotations

from html.parser import HTMLParser

#: Of a formula: how it is drawn, and how it was written.
SILENT = {"annotation"}
VOID = {"br", "hr", "img", "input", "wbr"}


def spoken(html: str) -> str:
    """Plain text in one line; empty where the HTML has no formula, and needs no help."""
    if "<math" not in html:
        return ""
    reader = _Reader()
    reader.feed(html)
    reader.close()
    return " ".join("".join(reader.said).split())


class _Reader(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.said: list[str] = []
        self._silent = 0  # how many open elements deep, within one that is not said

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag in VOID:
            return
        if self._silent or tag in SILENT or ("aria-hidden", "true") in attrs:
            self._silent += 1

    def handle_endtag(self, tag: str) -> None:
        if self._silent and tag not in VOID:
            self._silent -= 1

    def handle_data(self, data: str) -> None:
        if not self._silent:
            self.said.append(data)
