"""`%%balise l20/poses`: runs a cell, sends it, and shows its verdict with a figure."""

from __future__ import annotations

import base64
import html
from typing import Any

from . import report, tokens
from .connection import ServerConnection
from .errors import ClientError
from .exercises import find_exercise_id
from .release import SERVER


class NotebookVerdict:
    """A verdict as a notebook shows it: HTML, or text where there is no HTML."""

    def __init__(self, text: str, page: str, figure: bytes | None) -> None:
        self._text, self._page, self._figure = text, page, figure

    def __repr__(self) -> str:
        return self._text

    def _repr_html_(self) -> str:
        address = html.escape(self._page)
        text = html.escape(self._text.removesuffix(self._page).rstrip())
        shown = f"<pre>{text}</pre>"
        if self._figure is not None:
            data = base64.b64encode(self._figure).decode()
            shown += f'<img alt="Figure du contre-exemple" src="data:image/svg+xml;base64,{data}">'
        return f'{shown}<p><a href="{address}">Voir l’essai</a></p>'


def register_cell_magic(shell: Any) -> None:
    """Add the cell magic to an IPython shell."""

    def balise(line: str, cell: str) -> NotebookVerdict | None:
        shell.run_cell(cell)
        try:
            return grade_cell(line.strip(), cell)
        except ClientError as error:
            print(f"balise : {error}")
            return None

    shell.register_magic_function(balise, "cell", "balise")


def grade_cell(exercise: str, cell: str) -> NotebookVerdict:
    """Send a cell; return its verdict. Raises ClientError."""
    if not exercise:
        raise ClientError("quel exercice ? Écrivez par exemple « %%balise l20/poses » en tête de la cellule.")
    connection = ServerConnection(SERVER, tokens.find_token(SERVER))
    submission = connection.wait_until_graded_or_held(
        connection.submit(find_exercise_id(connection, exercise), {"code": cell})
    )
    page = connection.attempt_page_url(submission)
    return NotebookVerdict(report.render_verdict(submission, page), page, _load_first_figure(connection, submission))


def _load_first_figure(connection: ServerConnection, submission: dict[str, Any]) -> bytes | None:
    checks = (submission.get("verdict") or {}).get("checks", ())
    names = [check["figure"] for check in checks if check.get("figure") and not check["passed"]]
    if not names:
        return None
    return connection.get_bytes(f"/api/v1/submissions/{submission['id']}/figures/{names[0]}.svg")
