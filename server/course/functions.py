"""Functions that students write."""

from __future__ import annotations

from dataclasses import dataclass

from graders.core.declared.proposals import WHOLE_PROGRAM


@dataclass(frozen=True)
class FunctionSpec:
    """A function (or class) that the student writes. `signature` is shown as it stands.

    `parts` are the names of the values of the tuple that it returns, if that is what it does. `example` is a call to
    begin from, or empty. `promises` are what its contract says, as labels and texts in French.
    """

    name: str
    signature: str
    returns: str
    doc: str
    parts: tuple[str, ...] = ()
    example: str = ""
    promises: tuple[tuple[str, str], ...] = ()

    @property
    def is_class(self) -> bool:
        return self.signature.startswith("class ")

    @property
    def is_program(self) -> bool:
        """Whether the student's file is run whole, and this is no function."""
        return self.signature == WHOLE_PROGRAM

    @property
    def is_function(self) -> bool:
        return not (self.is_class or self.is_program)
