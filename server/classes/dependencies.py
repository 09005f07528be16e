"""Dependencies of routes."""

from typing import Annotated

from fastapi import Depends

from server.base.app_services import app_service
from server.classes.service import ClassService

ClassServiceOf = Annotated[ClassService, Depends(app_service(ClassService))]
