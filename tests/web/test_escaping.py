"""What templates write is what Jinja2 would have written, to a browser."""

from __future__ import annotations

from html import unescape

from hypothesis import given
from hypothesis import strategies as st
from jinja2 import Environment
from markupsafe import Markup, escape

from server.web.escaping import Pages, escaped

SHOW = "{% macro shown(one) %}<b>{{ one }}</b>{% endmacro %}{{ value }}{{ shown(value) }}{{ value ~ '<' }}{{ 'é<' }}"


class Says(str):
    """Markup of somebody else's making, as forms have it."""

    def __html__(self) -> str:
        return "<i>"


@given(text=st.text())
def test_text_is_read_as_it_was_written_and_nothing_else(text: str) -> None:
    written = str(escaped(text))
    assert unescape(written) == unescape(str(escape(text)))
    assert not set(written) & set("<>\"'")
    assert written.count("&") == sum(map(text.count, "<>&\"'"))


def test_what_is_markup_or_says_what_it_is_is_left_as_it_is() -> None:
    for value in (Markup("<b>&amp;"), Says("&"), 3, 2.5, None):
        assert str(escaped(value)) == str(escape(value))


@given(text=st.text(alphabet="a<>&\"'é"))
def test_templates_write_what_they_did(text: str) -> None:
    for value in (text, Markup("<b>") + text):
        ours, theirs = (kind(autoescape=True).from_string(SHOW).render(value=value) for kind in (Pages, Environment))
        assert ours.replace("&#x27;", "&#39;").replace("&quot;", "&#34;") == theirs


def test_a_template_may_still_say_that_nothing_is_escaped() -> None:
    said = "{% autoescape false %}{{ value }}{% endautoescape %}{{ value }}"
    pages = Pages(autoescape=True)
    assert pages.from_string(said).render(value="<") == "<&lt;"
