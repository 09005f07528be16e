"""What routes ask of this room: figures of verdicts."""

from typing import Annotated

from fastapi import Depends

from server.base.provided import provided
from server.gradebook.figures import Figures

FiguresOf = Annotated[Figures, Depends(provided(Figures))]
