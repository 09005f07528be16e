"""What the numerics raise: a bad argument is named, never answered by a wrong number."""

from __future__ import annotations

from typing import Any, get_args


class InvalidArgumentError(ValueError):
    """Input from which nothing can be computed; `argument` names it, and the message says why."""

    def __init__(self, argument: str, reason: str) -> None:
        super().__init__(f"{argument}: {reason}")
        self.argument = argument


def check_choice(
    argument: str, word: object, words: Any, error: type[InvalidArgumentError] = InvalidArgumentError
) -> None:
    """Raise `error` unless `word` is one of `words`, a Literal type: a misspelt option takes no other meaning."""
    known = get_args(words)
    if not (isinstance(word, str) and word in known):
        raise error(argument, f"{word!r} is not one of {', '.join(map(repr, known))}")
