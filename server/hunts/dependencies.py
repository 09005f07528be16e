"""Dependencies of routes that ask about hunts."""

from typing import Annotated

from fastapi import Depends

from server.base.app_services import app_service
from server.hunts.service import HuntService

HuntsOf = Annotated[HuntService, Depends(app_service(HuntService))]
