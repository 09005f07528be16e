"""Request and response bodies of running a cell."""

from pydantic import BaseModel, ConfigDict


class NewRun(BaseModel):
    """The cell as the reader has changed it."""

    model_config = ConfigDict(extra="forbid")

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
