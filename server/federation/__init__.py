"""Sign-in through a school's own system, its courses, and marks sent back to it. See README.md in this folder."""
