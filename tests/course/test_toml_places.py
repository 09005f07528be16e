"""Where a value of a TOML text stands, however it is written."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from typing import Any

import pytest

from server.base.files import ROOT
from server.course.toml_places import Location, find_first_line_of_string, find_line_of_value

# Each value that is a whole number is the line on which it stands.
NUMBERED = '''a = 1
b.c.d = 2
b.c.e = 3
"clé avec [crochets] = et #" = 4
'l.m' = 5
f = { g = 6, h.i = 6, j = { k = 6 } }
trap = """
[section]
a = 99
[[list]]
"""
other = \'\'\'
a = 0
\'\'\'
list = [15, [15,
  16], # a comment
  # another
  18,
  { x = 19 }]
[table]
a = 21
[table.b."c d".e]
a = 23
b = """ [table] """
[unrelated]
a = 26
[[step]]
a = 28
[step.more]
a = 30
[[step.item]] # the first
a = 32
    [[ step . item ]]
    a = 34
    [step.item.deep]
    a = 36
[[step]]

a = 39
[[step.item]]
a = 41
[[step.item.x.y]]
a = 43
[[step.item.x.y]]
a = 45
'''


def leaves(value: Any, location: Location = ()) -> Iterator[tuple[Location, Any]]:
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else None
    if items is None:
        yield location, value
        return
    for name, item in items:
        yield from leaves(item, (*location, name))


def test_every_number_is_found_on_the_line_that_it_says() -> None:
    numbers = [(location, value) for location, value in leaves(tomllib.loads(NUMBERED)) if isinstance(value, int)]
    assert len(numbers) == 25
    assert {location: find_line_of_value(NUMBERED, location) for location, _ in numbers} == dict(numbers)


@pytest.mark.parametrize(
    ("location", "line"),
    [
        (("absent",), 1),
        ((), 1),
        (("b",), 2),
        (("b", "c", "absent"), 2),
        (("f", "absent"), 6),
        (("list", 3, "absent"), 19),
        (("list", 9), 15),
        (("table", "b"), 22),
        (("table", "b", "c d", "absent"), 22),
        (("step",), 27),
        (("step", 0, "absent"), 27),
        (("step", 0, "item", 1, "absent"), 33),
        (("step", 1, "item", 0, "x", "y", 1, "absent"), 44),
        (("step", 1, "item", 5), 40),
        (("step", 1, "absent", 0, "id"), 37),
    ],
)
def test_what_is_not_there_is_told_on_what_should_hold_it(location: Location, line: int) -> None:
    assert find_line_of_value(NUMBERED, location) == line


def test_the_text_of_a_string_begins_below_its_quotes_where_a_line_end_follows_them() -> None:
    text = 'a = "x"\nb = """y\nz"""\nc = """\ny"""\nd = [\'\'\'\ny\'\'\', """x"""]\n[e]\nf = ""\ng = """"""\n'
    begins = {location: find_first_line_of_string(text, location) for location, _ in leaves(tomllib.loads(text))}
    assert begins == {("a",): 1, ("b",): 2, ("c",): 5, ("d", 0): 7, ("d", 1): 7, ("e", "f"): 9, ("e", "g"): 10}


def test_everything_in_the_course_s_own_files_is_found_on_a_line_that_names_it() -> None:
    paths = sorted((ROOT / "curriculum").rglob("*.toml"))
    assert len(paths) > 15
    for path in paths:
        text = path.read_text(encoding="utf-8")
        lines = text.splitlines()
        for location, _ in leaves(tomllib.loads(text)):
            key = next(part for part in reversed(location) if isinstance(part, str))
            line = lines[find_line_of_value(text, location) - 1]
            assert key in line or isinstance(location[-1], int), (path, location)
