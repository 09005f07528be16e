"""What routes ask of this room."""

from typing import Annotated

from fastapi import Depends

from server.base.provided import provided
from server.regrades.service import RegradeService

RegradeServiceOf = Annotated[RegradeService, Depends(provided(RegradeService))]
