"""Values, messages and texts made to break a page or a figure: from a student's file, graded, to what is shown."""

from __future__ import annotations

import json
import unicodedata
from html.parser import HTMLParser
from xml.etree import ElementTree

import pytest

from graders.core.contract.findings import Judgement
from graders.core.contract.verdict import Verdict
from server.grading.sandbox_grader import SandboxGrader
from server.sandbox import Sandbox
from server.web import verdicts
from server.web.rendering import jinja_environment
from tests.support.quick import the_course
from tests.support.small_site import SmallSite

SHOW = '{% from "verdict.html" import show_verdict %}{{ show_verdict(verdict, 1) }}'
TEXT = (
    "'<script>alert(1)</script></pre><img src=x onerror=alert(2)>`<b>`{{ 7*7 }}{% raw %}&#60;i&#62;"
    "\\x1b[2J\\x1b]8;;http://example.org\\x07\\u202e\\u2066\\u200b\\ufeff\\x85\\0\\ud800\\U000e0041'"
)
VALUES = {
    "text": "TEXTE",
    "long-text": "'x' * 10**5",
    "texts-among-numbers": "['x' * 100_000] + [1] * 2000",
    "keys": "{TEXTE: [TEXTE], 'forme': 3}",
    "forged-summary": "{'forme': 7, 'premiers': TEXTE}",
    "integer-beyond-floats": "10**1200",
    "integers-beyond-floats": "[-10**1200] * 3",
    "largest": "np.full(3, 1e308)",
    "opposite": "np.array([1e308, -1e308, np.pi])",
    "not-numbers": "np.array([np.nan, np.inf, -np.inf])",
    "not-numbers-everywhere": "np.full(3, np.nan)",
    "smallest": "[5e-324, -0.0, 0.0]",
    "complex": "complex(1e308, float('nan'))",
    "integers": "np.full(3, 2**64 - 1, dtype=np.uint64)",
    "empty-and-wide": "np.zeros((0, 2**20))",
    "raise": "leve(TEXTE)",
    "raise-another": "leve(TEXTE, type('<u>E\\x1b' + 'é' * 500, (Exception,), {}))",
}  # fmt: skip
HEAD = f"""
import os, sys
TEXTE = {TEXT}
def leve(texte, genre=ValueError):
    raise genre(texte)
print(TEXTE)
sys.stderr.write("\\x9b31m\\r\\n" + "|" * 5000)
os.write(1, b"\\xff\\x1b[2J</pre><script>alert(3)</script>")
"""


def attack(exercise: str, value: str) -> bytes:
    functions = the_course().exercises[exercise].grader.functions
    return (HEAD + "".join(f"def {name}(*_):\n    return {value}\n" for name in functions)).encode()


@pytest.fixture(scope="module")
def grader(course_sandbox: Sandbox) -> SandboxGrader:
    return SandboxGrader(the_course(), course_sandbox)


class Tags(HTMLParser):
    """The elements and attributes of a page, as a browser would see them."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.seen: set[str] = set()
        self.feed(page)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.seen |= {tag, *(name for name, _ in attrs)}


def assert_harmless(html: str) -> None:
    """No element or attribute of the student's, no character that hides, reorders or controls."""
    assert Tags(html).seen.isdisjoint({"script", "onerror", "b", "i", "u"}), Tags(html).seen
    assert "alert(" not in "".join(part.partition(">")[0] for part in html.split("<")[1:])
    hidden = {c for c in html if unicodedata.category(c) in ("Cc", "Cf", "Cs", "Zl", "Zp", "Co")} - {"\n"}
    assert hidden == set()


def shown(grading: Judgement) -> str:
    stored = json.loads(json.dumps(grading.verdict.to_json(), allow_nan=False))
    return (
        jinja_environment()
        .from_string(SHOW)
        .render(verdict=verdicts.build_verdict_view(Verdict.from_json(stored), "/figures"))
    )


@pytest.mark.parametrize(
    ("exercise", "value"),
    [
        *(("l20/poses", value) for value in VALUES),
        ("l20/boucles", "texts-among-numbers"),
        ("l20/boucles", "forged-summary"),
    ],
)
def test_an_odd_value_gets_a_verdict_that_can_be_shown(grader: SandboxGrader, exercise: str, value: str) -> None:
    grading = grader.grade(exercise, attack(exercise, VALUES[value]), seed=3)
    outcomes = ("wrong_answer", "invalid_output", "output_limit", "runtime_error")
    assert grading.verdict.outcome in outcomes, grading.verdict
    assert_harmless(shown(grading))


@pytest.mark.parametrize("value", ["largest", "smallest", "not-numbers"])
def test_odd_numbers_can_be_drawn(grader: SandboxGrader, value: str) -> None:
    from graders.plotting import counterexample  # loads matplotlib

    grading = grader.grade("l20/poses", attack("l20/poses", VALUES[value]), seed=3)
    assert grading.figures
    name, data = next(iter(grading.figures.items()))
    drawn = counterexample("l20/poses", json.loads(json.dumps(data, allow_nan=False)))
    assert ElementTree.fromstring(drawn).tag.endswith("svg"), name


@pytest.mark.parametrize("value", ["text", "keys", "raise-another"])
def test_an_attack_is_stored_and_shown_on_the_whole_page(
    grader: SandboxGrader, small_site: SmallSite, value: str
) -> None:
    code = attack("l20/poses", VALUES[value])
    verdict = grader.grade("l20/poses", code, seed=3).verdict.to_json()
    page = small_site.get(small_site.attempt(code.decode(), verdict))
    verdict_part = page[page.index('id="titre-verdict"') : page.index("</main>")]
    assert_harmless(verdict_part)
    assert "&lt;script&gt;alert(3)" in verdict_part
