"""Dependencies of routes."""

from typing import Annotated

from fastapi import Depends

from server.base.app_services import app_service
from server.regrades.service import RegradeService

RegradeServiceOf = Annotated[RegradeService, Depends(app_service(RegradeService))]
