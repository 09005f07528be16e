"""l20/demo_5: the steps of the proof that a loop closure bounds the uncertainty."""

from __future__ import annotations

from graders.core.answers import order

GRADER = order(__file__, "l20/demo_5")
