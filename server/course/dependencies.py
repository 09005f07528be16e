"""The course, as routes ask for it."""

from typing import Annotated

from fastapi import Depends

from server.base.provided import provided
from server.course.models import Course

CourseOf = Annotated[Course, Depends(provided(Course))]
