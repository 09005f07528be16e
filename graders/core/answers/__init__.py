"""Exercises answered without code: numbers, choices, steps to put in order. The same verdict as for code.

The course holds the texts, in `questions.toml`, and passes them as a sheet. `choice` and `order` need nothing else; for
`numeric`, a grader's folder defines how the data of a variant are drawn and its answers judged.
"""

from graders.core.answers.choice import ChoiceSheet, Option, make_choice_grader
from graders.core.answers.judging import AnswersGrader
from graders.core.answers.numeric import NumericDefinition, numeric
from graders.core.answers.order import Distractor, OrderSheet, ProofStep, make_order_grader
from graders.core.answers.quantity import Quantity
from graders.core.answers.question_paper import GivenDatum, Paper, PaperPiece, Question
from graders.core.answers.reading import canonical_json
from graders.core.answers.sheet import MalformedSheetError
from graders.core.answers.wording import Datum, NumericSheet

__all__ = [
    "AnswersGrader",
    "ChoiceSheet",
    "Datum",
    "Distractor",
    "GivenDatum",
    "MalformedSheetError",
    "NumericDefinition",
    "NumericSheet",
    "Option",
    "OrderSheet",
    "Paper",
    "PaperPiece",
    "ProofStep",
    "Quantity",
    "Question",
    "canonical_json",
    "make_choice_grader",
    "make_order_grader",
    "numeric",
]
