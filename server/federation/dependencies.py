"""The room's service, injected into routes."""

from typing import Annotated

from fastapi import Depends

from server.base.app_services import app_service
from server.federation.service import Federation

FederationOf = Annotated[Federation, Depends(app_service(Federation))]
