"""l20/demo_3: the steps of the proof of Kabsch's rotation."""

from __future__ import annotations

from graders.core.answers import order

GRADER = order(__file__, "l20/demo_3")
