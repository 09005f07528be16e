"""The course, as routes ask for it."""

from typing import Annotated

from fastapi import Depends

from server.base.app_services import provided
from server.course.models import Course

CourseOf = Annotated[Course, Depends(provided(Course))]
