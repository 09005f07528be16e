"""l20/demo_2: the steps from Bayes' formula to a sum of log-odds."""

from __future__ import annotations

from graders.core.answers import order

GRADER = order(__file__, "l20/demo_2")
