"""l20/demo_1: the steps of the proof of the Bayes filter."""

from __future__ import annotations

from graders.core.answers import order

GRADER = order(__file__, "l20/demo_1")
