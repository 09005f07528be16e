"""l20/verification: the questions at the end of the module."""

from __future__ import annotations

from graders.core.answers import choice

GRADER = choice(__file__, "l20/verification")
