"""Dependencies of routes."""

from typing import Annotated

from fastapi import Depends

from server.base.app_services import app_service
from server.classes.presence import PresenceRecorder
from server.classes.service import ClassService

ClassServiceOf = Annotated[ClassService, Depends(app_service(ClassService))]
PresenceOf = Annotated[PresenceRecorder, Depends(app_service(PresenceRecorder))]
