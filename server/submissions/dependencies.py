"""What routes ask of this room: news of submissions."""

from typing import Annotated

from fastapi import Depends

from server.base.provided import provided
from server.submissions.events import Events

EventsOf = Annotated[Events, Depends(provided(Events))]
