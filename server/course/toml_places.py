"""Line numbers of the values of a TOML text, from its syntax tree (tomllib keeps none)."""

from __future__ import annotations

import tomllib
from collections import Counter
from collections.abc import Iterator
from functools import lru_cache
from typing import Any

import tree_sitter_toml
from tree_sitter import Language, Node, Parser, Tree

Location = tuple[int | str, ...]
TABLES = {"table", "table_array_element"}
TOML = Language(tree_sitter_toml.language())


def find_line_of_value(text: str, location: Location) -> int:
    """The line (from 1) of the value at `location`, or of the innermost table that is there and should hold it."""
    lines = _line_index(text).lines
    return next((lines[place] for place in _location_prefixes(location) if place in lines), 1)


def find_first_line_of_string(text: str, location: Location) -> int:
    """The line on which a string's own text begins: below the quotes, where a line end follows them."""
    return _line_index(text).texts[location]


def _location_prefixes(location: Location) -> Iterator[Location]:
    return (location[:length] for length in range(len(location), 0, -1))


class _LineIndex:
    """The line of each table, key and item, and of the text of each string."""

    def __init__(self, tree: Tree) -> None:
        self.lines: dict[Location, int] = {}
        self.texts: dict[Location, int] = {}
        self._tables: Counter[Location] = Counter()  # how many [[name]] there have been
        for node in tree.root_node.named_children:
            if node.type in TABLES:
                self._index_table(node)
            elif node.type == "pair":
                self._index_pair(node, ())

    def _index_table(self, node: Node) -> None:
        header, *pairs = node.named_children
        *above, name = _key_parts(header)
        location: Location = ()
        for part in above:
            location = self._latest_table_of_name((*location, part))
        location = (*location, name)
        self._note_line(location, node)
        if node.type == "table_array_element":
            self._tables[location] += 1
        location = self._latest_table_of_name(location)
        self._note_line(location, node)
        for pair in pairs:
            if pair.type == "pair":
                self._index_pair(pair, location)

    def _latest_table_of_name(self, location: Location) -> Location:
        """The table that a name stands for: the latest of its list, where it is a list."""
        count = self._tables[location]
        return (*location, count - 1) if count else location

    def _index_pair(self, node: Node, table: Location) -> None:
        key, value = (child for child in node.named_children if child.type != "comment")
        self._index_value(value, (*table, *_key_parts(key)), node)

    def _index_value(self, node: Node, location: Location, written: Node) -> None:
        """`written` is where one looks for it: its key, or itself in a list."""
        self._note_line(location, written)
        inside = [child for child in node.named_children if child.type != "comment"]
        if node.type == "array":
            for index, item in enumerate(inside):
                self._index_value(item, (*location, index), item)
        elif node.type == "inline_table":
            for pair in inside:
                self._index_pair(pair, location)
        elif node.type == "string":
            below = (node.text or b"")[3:4] == b"\n" and (node.text or b"")[:3] in {b'"""', b"'''"}
            self.texts[location] = node.start_point.row + 1 + below

    def _note_line(self, location: Location, node: Node) -> None:
        for place in _location_prefixes(location):
            self.lines.setdefault(place, node.start_point.row + 1)


def _key_parts(key: Node) -> list[str]:
    """The parts of a key, quoted or dotted, as what reads TOML understands them."""
    value: Any = tomllib.loads(f"{(key.text or b'').decode()} = 0")
    names: list[str] = []
    while isinstance(value, dict):
        (name,) = value
        names.append(name)
        value = value[name]
    return names


@lru_cache(maxsize=64)
def _line_index(text: str) -> _LineIndex:
    return _LineIndex(Parser(TOML).parse(text.encode()))
