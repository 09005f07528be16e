"""FastAPI dependencies of figures."""

from typing import Annotated

from fastapi import Depends

from server.base.app_services import app_service
from server.figures.service import FigureService

FiguresOf = Annotated[FigureService, Depends(app_service(FigureService))]
