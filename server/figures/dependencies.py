"""What routes ask of this room."""

from typing import Annotated

from fastapi import Depends

from server.base.provided import provided
from server.figures.service import Figures

FiguresOf = Annotated[Figures, Depends(provided(Figures))]
