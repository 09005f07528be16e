"""The graders of code that are shipped."""

from __future__ import annotations

from graders.core.code.grading import CodeGrader
from tests.support.quick import the_course

CODE = {name: one.grader for name, one in the_course().exercises.items() if isinstance(one.grader, CodeGrader)}
