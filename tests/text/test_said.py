"""What people write to each other is shown as they wrote it, and does nothing."""

from __future__ import annotations

import re
from html import unescape

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from server.text.said import cached_message_html

#: A text, and its HTML.
CASES = {
    "Bonjour": "<p>Bonjour</p>\n",
    "un\ndeux\n\ntrois": "<p>un<br>\ndeux</p>\n<p>trois</p>\n",
    "avec `x < 1`": "<p>avec <code>x &lt; 1</code></p>\n",
    "```python\nx = a*b*c\n```": '<pre><code class="language-python">x = a*b*c\n</code></pre>\n',
    "x*y*z, __init__ et _v_": "<p>x*y*z, __init__ et _v_</p>\n",
    "# pas un titre\n- ni une liste": "<p># pas un titre<br>\n- ni une liste</p>\n",
    "<b>gras</b>": "<p>&lt;b&gt;gras&lt;/b&gt;</p>\n",
    "[ici](javascript:alert(1)) <http://a.fr>": "<p>[ici](javascript:alert(1)) &lt;http://a.fr&gt;</p>\n",
    "![x](http://a.fr/x.png)": "<p>![x](http://a.fr/x.png)</p>\n",
    "a\u202eb": "<p>a⟦U+202E⟧b</p>\n",
}


@pytest.mark.parametrize("text", list(CASES))
def test_a_message_is_shown_as_it_was_written(text: str) -> None:
    assert cached_message_html(text) == CASES[text]


PIECES = ["<script>", "</p>", '"', "onerror=", "```", "`", "\n", "    ", "&lt;", "<!--", "x", "[a](b)", "*", "~~~ <i>"]


@settings(max_examples=60, deadline=None)
@given(st.lists(st.sampled_from(PIECES), max_size=15).map("".join))
def test_nothing_but_four_elements_ever_comes_out(text: str) -> None:
    html = cached_message_html(text)
    tags = re.findall(r"<[^>]*>", html)
    plain = re.compile(r"</?(p|code|pre)>|<br>|<code class=\"language-[^\"<>]*\">")
    assert [tag for tag in tags if not plain.fullmatch(tag)] == []
    assert html.count("<") == len(tags)
    if "`" not in text and "~" not in text:
        shown = unescape(re.sub(r"<[^>]*>", "", html))
        assert "".join(shown.split()) == "".join(text.split())


def test_a_message_is_rendered_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """A hundred messages of a page, each of 1,300 paragraphs, were a second of everybody's processor at each view."""
    text = f"a\n\n{id(monkeypatch)}\n\n" * 3
    html = cached_message_html(text)
    monkeypatch.setattr("server.text.said.render_message_html", lambda _text: pytest.fail("it is remembered"))
    assert cached_message_html(text) == html
