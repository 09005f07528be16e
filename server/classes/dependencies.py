"""What the application has been built with, for the routes."""

from typing import Annotated

from fastapi import Depends

from server.base.provided import provided
from server.classes.presence import Presence
from server.classes.service import Classes

ClassesOf = Annotated[Classes, Depends(provided(Classes))]
PresenceOf = Annotated[Presence, Depends(provided(Presence))]
