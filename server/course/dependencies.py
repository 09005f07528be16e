"""The course, as routes ask for it."""

from typing import Annotated

from fastapi import Depends

from server.base.app_services import app_service
from server.course.models import Course

CourseOf = Annotated[Course, Depends(app_service(Course))]
