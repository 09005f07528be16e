"""What statements were compiled to, found by what they are rather than by what they are made of.

SQLAlchemy looks for it by a key that tells all of a statement, and hashes that each time. Of a statement that is made
once (`prepared`) the key is the same object each time, and its address will do.
"""

from __future__ import annotations

from typing import Any

from sqlalchemy.util import LRUCache

MOST = 1000


class Compiled(LRUCache[Any, Any]):
    """As SQLAlchemy keeps it, with what was found lately by the address of its key, which is kept with it: no other
    object has that address meanwhile."""

    def __init__(self) -> None:
        super().__init__(MOST)
        self._same: dict[Any, tuple[object, Any]] = {}

    def get(self, key: Any, default: Any = None) -> Any:
        """`key` is the dialect, the statement's own key, the names of its values, and more of the kind."""
        address = (id(key[1]), *key[:1], *key[2:])
        same = self._same.get(address)
        if same is not None:
            return same[1]
        found = super().get(key, default)
        if found is not None:
            if len(self._same) >= MOST:
                self._same.clear()
            self._same[address] = key[1], found
        return found
