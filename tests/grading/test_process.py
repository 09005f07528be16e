"""A worker's process: it imports less than the service and the tests do, and in another order."""

from __future__ import annotations

import subprocess
import sys

from server.base.paths import ROOT as PROJECT

#: Of each statement that a module keeps: its parameters that have no type, and so would reach the driver as they are.
UNTYPED = """
import sys
import server.grading.process
from sqlalchemy import ClauseElement
from sqlalchemy.types import NullType
statements = 0
for name, module in list(sys.modules.items()):
    for label, kept in list(vars(module).items()) if name.startswith("server.") else ():
        if isinstance(kept, ClauseElement) and hasattr(kept, "compile") and label.isupper():
            statements += 1
            binds = kept.compile().binds
            print(*(f"{name}.{label}:{bind}" for bind, one in binds.items() if isinstance(one.type, NullType)))
assert statements > 4
"""


def test_the_statements_that_modules_keep_know_their_types_whatever_was_imported_first() -> None:
    """A parameter takes the type of its column, which takes that of the table it refers to, if it is there by then."""
    told = subprocess.run([sys.executable, "-c", UNTYPED], cwd=PROJECT, capture_output=True, text=True, check=True)
    assert told.stdout.split() == []
