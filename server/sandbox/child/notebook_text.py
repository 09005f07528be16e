"""Traces of a notebook or of a console in a file that does not compile: magics, prompts, fences.

Lines keep their numbers, so that a message about the file tells the student's own.
"""

from __future__ import annotations

import re

#: What was let through, and the number of its first line.
Note = tuple[str, "int | str"]
MAGIC, PROMPT, FENCE = "magic", "prompt", "fence"
_MAGIC = re.compile(r"(\s*)(?:%%?[A-Za-z]|!\s*[A-Za-z]|\?\??[A-Za-z_]|[A-Za-z_][\w.]*\?\??\s*$)")
_PROMPT = re.compile(r"\s*(?:>>>|In \[\d*\]:) ?")
_CONTINUATION = re.compile(r"\s*(?:\.\.\.:?)(?: |$)")
_OUTPUT = re.compile(r"\s*Out\[\d*\]:")
_FENCE = re.compile(r"\s*(?:```|~~~)\s*\w*\s*$")
_STATEMENT = re.compile(r"(?:def|class|import|from|@|if|for|while|with|try|return|#)\b|[@#]")


def clean_notebook_text(text: str) -> tuple[str, tuple[Note, ...]]:
    """Return the text without what only a notebook or a console understands, and what that was."""
    lines = re.split("\r\n|\r|\n", text)
    notes: dict[str, int] = {}
    in_session = False
    for number, line in enumerate(lines, 1):
        if _FENCE.match(line):
            kind, lines[number - 1] = FENCE, ""
        elif prompt := _PROMPT.match(line):
            kind, lines[number - 1], in_session = PROMPT, line[prompt.end() :], True
        elif in_session and (prompt := _CONTINUATION.match(line)):
            kind, lines[number - 1] = PROMPT, line[prompt.end() :]
        elif _OUTPUT.match(line) or (in_session and line.strip() and not _STATEMENT.match(line)):
            kind, lines[number - 1] = PROMPT, ""
        elif magic := _MAGIC.match(line):
            kind, lines[number - 1] = MAGIC, f"{magic[1]}pass"
        else:
            in_session = in_session and bool(line.strip()) and not _STATEMENT.match(line)
            continue
        notes.setdefault(kind, number)
    return "\n".join(lines), tuple(notes.items())
