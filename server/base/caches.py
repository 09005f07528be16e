"""A thread-safe LRU cache."""

from collections.abc import Callable
from threading import Lock
from typing import Generic, TypeVar

import cachetools

Key = TypeVar("Key")
Value = TypeVar("Value")


class LRUCache(Generic[Key, Value]):
    """A cache of at most `max_size` entries, or of a total weight of `max_size` where `weigh` is given. Thread-safe.

    A value that outweighs the whole cache is not stored.
    """

    def __init__(self, max_size: int, weigh: Callable[[Value], int] | None = None) -> None:
        self._values: cachetools.LRUCache[Key, Value] = cachetools.LRUCache(max_size, getsizeof=weigh)
        self._lock = Lock()

    def get(self, key: Key) -> Value | None:
        """Return the cached value, or None."""
        with self._lock:
            return self._values.get(key)

    def put(self, key: Key, value: Value) -> Value:
        """Store `value` and return it."""
        with self._lock:
            if self._values.getsizeof(value) <= self._values.maxsize:
                self._values[key] = value
        return value

    def clear(self) -> None:
        with self._lock:
            self._values.clear()
