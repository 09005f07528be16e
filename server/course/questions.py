"""`questions.toml`: what students read of an exercise answered without code, strict, with the line of each fault."""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, Field

from graders.core.answers import (
    AnswersGrader,
    MalformedSheetError,
    NumericDefinition,
    make_choice_grader,
    make_order_grader,
)
from graders.core.answers.choice import ChoiceQuestion, ChoiceSheet, Option
from graders.core.answers.order import Distractor, OrderSheet, ProofStep
from graders.core.answers.wording import Datum, NumericSheet, NumericWording
from graders.core.contract.definition import Definition
from graders.core.contract.malformed import MalformedExerciseError
from server.course import toml_file
from server.course.models import CourseFault, Problem
from server.course.schemas import StrictModel
from server.course.schemas import Text as Words
from server.course.toml_places import Location, find_first_line_of_string, find_line_of_value
from server.text.markup import MarkdownSource, MarkdownText, ModuleNames

Id = Annotated[str, Field(pattern=r"^[a-z][a-z0-9_]{0,39}$")]
FILE = "questions.toml"
INSTRUCTION = "Mettez dans l’ordre les étapes de la démonstration, et laissez de côté celles qui n’en sont pas."
PLAIN = frozenset({"id", "form", "title", "section", "unit", "name", "misconception", "after", "symbol"})


class DatumEntry(StrictModel):
    """A number of the deal: `name` for the grader, `symbol` in TeX, `meaning` in words."""

    name: Id | Annotated[str, Field(pattern=r"^[A-Za-z]\w{0,39}$")]
    symbol: Words
    unit: str = ""
    digits: Annotated[int, Field(ge=0, le=12)] = 2
    meaning: Words


class NumericEntry(StrictModel):
    id: Id
    title: str = ""
    text: Words
    unit: str = ""
    hint: str = ""
    correction: str = ""


class NumericFile(StrictModel):
    form: Literal["numeric"]
    data: Annotated[list[DatumEntry], Field(min_length=1)]
    question: Annotated[list[NumericEntry], Field(min_length=1)]


class OptionEntry(StrictModel):
    id: Id
    right: bool = False
    text: Words
    why: Words
    misconception: Id | None = None


class ChoiceEntry(StrictModel):
    id: Id
    title: str = ""
    text: Words
    points: Annotated[float, Field(gt=0)] = 1
    several: bool = False
    section: str = ""
    hint: str = ""
    option: Annotated[list[OptionEntry], Field(min_length=2)]


class ChoiceFile(StrictModel):
    form: Literal["choice"]
    question: Annotated[list[ChoiceEntry], Field(min_length=1)]


class StepEntry(StrictModel):
    id: Id
    text: Words
    role: Words
    after: list[Id] | None = None


class DistractorEntry(StrictModel):
    id: Id
    text: Words
    why: Words
    misconception: Id | None = None


class OrderFile(StrictModel):
    form: Literal["order"]
    instruction: Words = INSTRUCTION
    step: Annotated[list[StepEntry], Field(min_length=2)]
    distractor: Annotated[list[DistractorEntry], Field(default_factory=list)]


def _title_or_number(title: str, place: int) -> str:
    return title or f"Question {place}"


def _build_numeric_sheet(file: NumericFile) -> NumericSheet:
    data = tuple(Datum(datum.name, datum.symbol, datum.unit, datum.digits, datum.meaning) for datum in file.data)
    questions = tuple(
        NumericWording(
            question.id,
            _title_or_number(question.title, place),
            question.text,
            question.unit,
            question.hint,
            question.correction,
        )
        for place, question in enumerate(file.question, 1)
    )
    return NumericSheet(data, questions)


def _build_choice_sheet(file: ChoiceFile) -> ChoiceSheet:
    return ChoiceSheet(
        tuple(
            ChoiceQuestion(
                id=question.id,
                title=_title_or_number(question.title, place),
                text=question.text,
                points=question.points,
                several=question.several,
                hint=question.hint,
                section=question.section,
                options=tuple(
                    Option(option.id, option.right, option.text, option.why, option.misconception)
                    for option in question.option
                ),
            )
            for place, question in enumerate(file.question, 1)
        )
    )


def _build_order_sheet(file: OrderFile) -> OrderSheet:
    steps = []
    for place, step in enumerate(file.step):
        before = (file.step[place - 1].id,) if place else ()
        steps.append(ProofStep(step.id, step.text, step.role, before if step.after is None else tuple(step.after)))
    false = tuple(
        Distractor(distractor.id, distractor.text, distractor.why, distractor.misconception)
        for distractor in file.distractor
    )
    return OrderSheet(file.instruction, tuple(steps), false)


class QuestionFormField(BaseModel):
    """The one field that says which others a file has."""

    form: Literal["numeric", "choice", "order"]


FILES: Mapping[str, type[NumericFile | ChoiceFile | OrderFile]] = {
    "numeric": NumericFile,
    "choice": ChoiceFile,
    "order": OrderFile,
}


@dataclass(frozen=True)
class QuestionsFile:
    """What a `questions.toml` says, before it is known what grades it."""

    path: Path
    file: NumericFile | ChoiceFile | OrderFile

    @property
    def needs_grader(self) -> bool:
        """Whether a grader's folder goes with it: the other forms hold their own answers."""
        return isinstance(self.file, NumericFile)

    def build_grader(self, exercise: str, definition: Definition | None) -> AnswersGrader:
        """The grader of the exercise. Raises CourseFault where definition and questions do not go together."""
        try:
            return self._build_grader_unchecked(exercise, definition)
        except MalformedExerciseError as error:
            raise CourseFault(Problem(error.path, error.line, error.message)) from error
        except MalformedSheetError as error:
            line = find_line_of_value(toml_file.read_text(self.path), error.at)
            raise CourseFault(Problem(self.path, line, error.message)) from error

    def _build_grader_unchecked(self, exercise: str, definition: Definition | None) -> AnswersGrader:
        if isinstance(self.file, NumericFile):
            assert isinstance(definition, NumericDefinition), "no other definition is of an exercise without code"
            return definition.bind(_build_numeric_sheet(self.file))
        if definition is not None:
            raise MalformedExerciseError(definition.file, f'form = "{self.file.form}" : ce correcteur est de trop')
        if isinstance(self.file, ChoiceFile):
            return make_choice_grader(exercise, self.path.parent, _build_choice_sheet(self.file))
        return make_order_grader(exercise, self.path.parent, _build_order_sheet(self.file))


def read_questions(path: Path) -> QuestionsFile:
    """Read the questions of an exercise. Raises CourseFault with the place of the first fault."""
    form = toml_file.read_toml(path, QuestionFormField).form
    file = toml_file.read_toml(path, FILES[form])
    _require_distinct_names(path, file)
    return QuestionsFile(path, file)


def _require_distinct_names(path: Path, file: BaseModel) -> None:
    """No two tables of one name in the same list."""
    for location, names in _iterate_table_names(file.model_dump(), ()):
        for place, name in enumerate(names):
            if name in names[:place]:
                line = find_line_of_value(path.read_text(encoding="utf-8"), (*location, place, "id"))
                raise CourseFault(Problem(path, line, f"nom donné deux fois : « {name} »"))


def _iterate_table_names(value: Any, location: Location) -> Iterator[tuple[Location, list[str]]]:
    if isinstance(value, dict):
        for key, item in value.items():
            yield from _iterate_table_names(item, (*location, key))
    elif isinstance(value, list) and all(isinstance(item, dict) for item in value):
        yield location, [str(item.get("id", item.get("name"))) for item in value]
        for place, item in enumerate(value):
            yield from _iterate_table_names(item, (*location, place))


def find_question_text_problems(
    path: Path, grader: AnswersGrader, names: Callable[[], ModuleNames], *, formulas: bool
) -> Iterator[Problem]:
    """What is wrong with the texts of the questions, with its line."""
    text = toml_file.read_text(path)
    for location, wording in _iterate_markdown_texts(tomllib.loads(text), ()):
        source = MarkdownSource(
            grader.fill_with_sample_numbers(wording), path, find_first_line_of_string(text, location), names=names
        )
        for fault in MarkdownText(source).find_faults(formulas=formulas):
            yield Problem(path, fault.line, fault.message)


def _iterate_markdown_texts(value: Any, location: Location) -> Iterator[tuple[Location, str]]:
    """The texts that are Markdown, and the symbols as formulas."""
    key = next((part for part in reversed(location) if isinstance(part, str)), "")
    if isinstance(value, dict):
        for name, item in value.items():
            yield from _iterate_markdown_texts(item, (*location, name))
    elif isinstance(value, list):
        for index, item in enumerate(value):
            yield from _iterate_markdown_texts(item, (*location, index))
    elif isinstance(value, str) and key == "symbol":
        yield location, f"${value}$"
    elif isinstance(value, str) and key not in PLAIN:
        yield location, value
