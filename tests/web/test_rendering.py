"""The environment of the templates."""

from __future__ import annotations

from html import unescape

import pytest
from hypothesis import given
from hypothesis import strategies as st
from jinja2 import UndefinedError
from markupsafe import Markup

from server.web.rendering import jinja_environment

TEMPLATE = "{% macro bold(value) %}<b>{{ value }}</b>{% endmacro %}{{ bold(value) }}{{ value ~ '<' }}"


@given(text=st.text(alphabet="a<>&\"'é"))
def test_pages_escape_text(text: str) -> None:
    html = jinja_environment().from_string(TEMPLATE).render(value=text)
    assert unescape(html.removeprefix("<b>").replace("</b>", "")) == f"{text}{text}<"
    assert not set(html.replace("<b>", "").replace("</b>", "")) & set("<>\"'")


def test_pages_leave_markup_as_it_is() -> None:
    assert jinja_environment().from_string("{{ value }}").render(value=Markup("<b>&amp;")) == "<b>&amp;"


def test_pages_refuse_a_name_that_is_not_in_the_context() -> None:
    with pytest.raises(UndefinedError):
        jinja_environment().from_string("{{ missing }}").render()
