"""Dependencies of routes."""

from typing import Annotated

from fastapi import Depends

from server.base.app_services import app_service
from server.personal.service import PersonalDataService

PersonalDataOf = Annotated[PersonalDataService, Depends(app_service(PersonalDataService))]
