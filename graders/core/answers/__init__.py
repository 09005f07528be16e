"""Exercises answered without code: numbers, choices, steps to put in order. The same verdict as for code.

A grader's folder defines GRADER with `numeric`, `choice` or `order`; what students read stands in the course, in
`questions.toml`, and joins it as a sheet (`bind`).
"""

from graders.core.answers.choice import ChoiceSheet, Option, choice
from graders.core.answers.judging import AnswersDefinition, AnswersGrader
from graders.core.answers.numeric import Quantity, numeric
from graders.core.answers.order import Distractor, OrderSheet, Step, order
from graders.core.answers.paper import Given, Paper, Piece, Question
from graders.core.answers.reading import canonical
from graders.core.answers.wording import Datum, NumericSheet

__all__ = [
    "AnswersDefinition",
    "AnswersGrader",
    "ChoiceSheet",
    "Datum",
    "Distractor",
    "Given",
    "NumericSheet",
    "Option",
    "OrderSheet",
    "Paper",
    "Piece",
    "Quantity",
    "Question",
    "Step",
    "canonical",
    "choice",
    "numeric",
    "order",
]
