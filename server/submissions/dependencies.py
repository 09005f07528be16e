"""What routes ask of this room: taking submissions in, and news of them."""

from typing import Annotated

from fastapi import Depends

from server.base.app_services import app_service
from server.submissions.collecting import Collecting
from server.submissions.events import Events
from server.submissions.service import Submissions

EventsOf = Annotated[Events, Depends(app_service(Events))]
CollectingOf = Annotated[Collecting, Depends(app_service(Collecting))]
SubmissionsOf = Annotated[Submissions, Depends(app_service(Submissions))]
