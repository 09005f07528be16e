"""What beginners meet among the errors of Python and its libraries, in French: the cause, its line, what to write.

Each function takes the words of an exception, and returns a sentence, or None where it has nothing better to say than
the advice by the type of the exception.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

from server.sandbox import renamed_names
from server.sandbox.explanations.attributes import explain_attribute, explain_module_name, explain_numpy_name
from server.sandbox.explanations.names import explain_name
from server.sandbox.explanations.values import explain_value, with_values
from server.sandbox.faults import Frame

__all__ = ["explain_error", "explain_import", "with_values"]


def explain_error(
    exception: str, text: str, values: str, frames: Sequence[Frame], file_lines: Sequence[str]
) -> str | None:
    """Return the explanation of an exception raised in the student's file; None where there is none.

    `values` says what the names on the guilty line are, as `child.report` has it.
    """
    source = frames[-1].source if frames else ""
    if exception in ("NameError", "UnboundLocalError"):
        return explain_name(text, frames, file_lines)
    if exception == "AttributeError":
        return explain_attribute(text, source)
    return explain_value(text, values, source)


def explain_import(exception: str, module: str, text: str) -> str | None:
    """Return what to import instead of a module or a name that is gone; None where there is nothing to say."""
    if exception == "ModuleNotFoundError" and (instead := renamed_names.MODULES.get(module)):
        return f"Le module « {module} » a disparu de Python 3 : {instead} le remplace."
    if match := re.match(r"cannot import name '(\w+)' from (?:partially initialized module )?'([\w.]+)'", text):
        name, origin = match.groups()
        return explain_numpy_name(name, "np") if origin == "numpy" else explain_module_name(origin, name)
    return None
