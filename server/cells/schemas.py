"""Request and response bodies of running a cell."""

from pydantic import BaseModel

from server.base.validation import RequestBody


class NewRun(RequestBody):
    """The cell as the reader has changed it."""

    code: str


class FaultOut(BaseModel):
    """What went wrong in the cell; `frames` lead to it, from the outside in."""

    title: str
    message: str
    line: int | None
    frames: list[str]


class RunOut(BaseModel):
    """What a run shows; `figures` are addresses of the kind ``data:image/png;base64,…``."""

    stdout: str
    truncated: bool
    fault: FaultOut | None
    figures: list[str]
    milliseconds: int
