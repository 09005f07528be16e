"""Dependencies of routes."""

from typing import Annotated

from fastapi import Depends

from server.base.app_services import app_service
from server.personal.service import PersonalData

PersonalDataOf = Annotated[PersonalData, Depends(app_service(PersonalData))]
