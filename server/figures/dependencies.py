"""What routes ask of this room."""

from typing import Annotated

from fastapi import Depends

from server.base.app_services import provided
from server.figures.service import Figures

FiguresOf = Annotated[Figures, Depends(provided(Figures))]
