"""What the numerics raise: a bad argument is named, never answered by a wrong number."""

from __future__ import annotations


class InvalidArgumentError(ValueError):
    """Input from which nothing can be computed; `argument` names it, and the message says why."""

    def __init__(self, argument: str, reason: str) -> None:
        super().__init__(f"{argument}: {reason}")
        self.argument = argument
