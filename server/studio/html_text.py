"""HTML of a statement made elsewhere, as Markdown: paragraphs, lists, code and emphasis; the rest is dropped."""

from __future__ import annotations

import re
from html.parser import HTMLParser

_AROUND = {"code": "`", "tt": "`", "b": "**", "strong": "**", "em": "*", "i": "*"}
_BEFORE = {
    "p": "\n\n", "div": "\n\n", "br": "\n", "ul": "\n\n", "ol": "\n\n", "li": "\n- ", "tr": "\n", "td": " ",
    "h1": "\n\n## ", "h2": "\n\n## ", "h3": "\n\n### ", "h4": "\n\n### ", "h5": "\n\n### ",
}  # fmt: skip
_DROPPED = ("script", "style")


class _MarkdownWriter(HTMLParser):
    def __init__(self) -> None:
        super().__init__(convert_charrefs=True)
        self.parts: list[str] = []
        self._code = self._dropped = False

    def handle_starttag(self, tag: str, attrs: object) -> None:
        if tag == "pre":
            self._code = True
            self.parts.append("\n\n```text\n")
        elif tag in _DROPPED:
            self._dropped = True
        elif not self._code or tag == "br":
            self.parts.append(_BEFORE.get(tag, _AROUND.get(tag, "")))

    def handle_endtag(self, tag: str) -> None:
        if tag == "pre":
            self._code = False
            self.parts.append("\n```\n\n")
        elif tag in _DROPPED:
            self._dropped = False
        elif not self._code:
            self.parts.append("\n\n" if tag == "p" else _AROUND.get(tag, ""))

    def handle_data(self, data: str) -> None:
        if not self._dropped:
            self.parts.append(data if self._code else re.sub(r"\s+", " ", data))


def html_to_markdown(text: str) -> str:
    """Return the text of a statement in HTML as Markdown."""
    writer = _MarkdownWriter()
    writer.feed(text)
    writer.close()
    written = re.sub(r"[ \t]+\n", "\n", "".join(writer.parts))
    return re.sub(r"\n{3,}", "\n\n", written).strip()
