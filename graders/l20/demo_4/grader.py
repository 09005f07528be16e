"""l20/demo_4: the steps of the proof that ICP goes down."""

from __future__ import annotations

from graders.core.answers import order

GRADER = order(__file__, "l20/demo_4")
