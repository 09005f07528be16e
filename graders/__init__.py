"""Graders: what is asked of a submission, and what its answers mean. Runs on the trusted side only."""

import reference
from graders import courses

__path__ = [str(room) for room in courses.room_folders(courses.GRADERS)]
reference.__path__ = [str(room) for room in courses.room_folders(courses.REFERENCE)]
