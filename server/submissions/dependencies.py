"""Dependencies of routes: submissions, the collector of sittings, job events."""

from typing import Annotated

from fastapi import Depends

from server.base.app_services import app_service
from server.submissions.job_events import JobEvents
from server.submissions.service import SubmissionService
from server.submissions.sitting_collector import SittingCollector

JobEventsOf = Annotated[JobEvents, Depends(app_service(JobEvents))]
SittingCollectorOf = Annotated[SittingCollector, Depends(app_service(SittingCollector))]
SubmissionsOf = Annotated[SubmissionService, Depends(app_service(SubmissionService))]
