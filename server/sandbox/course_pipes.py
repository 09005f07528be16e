"""The pipes between a program and the process that holds the course's functions (`child.course_channel`)."""

from __future__ import annotations

import os


class CourseChannel:
    """The ends of the pipes on which a program's calls reach the process of the course's functions, for that process.

    Nobody reads or writes them here; once both processes have theirs, these must be closed.
    """

    def __init__(self, *descriptors: int) -> None:
        self.descriptors = descriptors

    def close(self) -> None:
        descriptors, self.descriptors = self.descriptors, ()
        for descriptor in descriptors:
            os.close(descriptor)


def make_course_channel() -> tuple[CourseChannel, CourseChannel]:
    """Make two pipes; return the ends of the program and those of the process of the course's functions."""
    (read_asks, write_asks), (read_replies, write_replies) = os.pipe(), os.pipe()
    return CourseChannel(write_asks, read_replies), CourseChannel(read_asks, write_replies)
