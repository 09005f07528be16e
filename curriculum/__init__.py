"""What people read: lessons, glossary, figures, replays, statements, starters, hints, the kits."""

from graders import courses

__path__ = [str(room) for room in courses.room_folders(courses.CURRICULUM)]
