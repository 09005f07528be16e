"""Reports, from a helper process, of the call that a known mistake makes: the last one is the one that never ends."""

from __future__ import annotations

from collections.abc import Sequence

from graders.core.code.confined import report_progress
from graders.core.compare.words import text
from graders.core.contract.local import LocalProgram, LocalPrograms
from graders.core.contract.program import KitSettings, PlannedCalls, Reply
from graders.core.contract.values import Arguments, Value


def report_call(function: str, args: Arguments) -> None:
    """Say which call comes, where somebody wants to know."""
    report_progress(lambda: f"{function}({', '.join(map(text, args))})")


class ReportingProgram(LocalProgram):
    """A trusted program that reports each call before it makes it."""

    def call(self, function: str, *args: Value, return_arguments: bool = False) -> Reply:
        report_call(function, args)
        return super().call(function, *args, return_arguments=return_arguments)


class ReportingPrograms(LocalPrograms):
    """Starts trusted files whose calls are reported."""

    def open(self, source: bytes, kit: KitSettings, ahead: Sequence[PlannedCalls] = ()) -> ReportingProgram:
        report_progress(lambda: "le chargement du fichier")
        return ReportingProgram(source, kit)


REPORTING = ReportingPrograms()
