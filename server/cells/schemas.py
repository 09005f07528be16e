"""Request and response bodies of running a cell."""

from pydantic import BaseModel

from server.base.validation import RequestBody


class CellRunInput(RequestBody):
    """The cell as the reader has changed it."""

    code: str


class CellFault(BaseModel):
    """What went wrong in the cell; `frames` lead to it, from the outside in."""

    title: str
    message: str
    line: int | None
    frames: list[str]


class CellRunResult(BaseModel):
    """What a run shows; `figures` are addresses of the kind ``data:image/png;base64,…``."""

    stdout: str
    truncated: bool
    fault: CellFault | None
    figures: list[str]
    milliseconds: int
