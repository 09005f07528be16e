"""What routes ask of this room: taking submissions in, and news of them."""

from typing import Annotated

from fastapi import Depends

from server.base.app_services import provided
from server.submissions.collecting import Collecting
from server.submissions.events import Events
from server.submissions.service import Submissions

EventsOf = Annotated[Events, Depends(provided(Events))]
CollectingOf = Annotated[Collecting, Depends(provided(Collecting))]
SubmissionsOf = Annotated[Submissions, Depends(provided(Submissions))]
