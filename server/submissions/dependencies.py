"""What routes ask of this room: news of submissions, figures of verdicts."""

from typing import Annotated

from fastapi import Depends

from server.base.provided import provided
from server.submissions.events import Events
from server.submissions.figures import Figures

EventsOf = Annotated[Events, Depends(provided(Events))]
FiguresOf = Annotated[Figures, Depends(provided(Figures))]
