"""Questions answered by ticking: one option, or as many as are right."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from graders.core.answers.judging import AnswerCheck, Answers, AnswersGrader
from graders.core.answers.letters import MAX_LETTERS, Letters, rename_items
from graders.core.answers.mistakes import check_same_mistakes, read_mistakes
from graders.core.answers.question_paper import AnswerTranscript, Form, Paper, PaperPiece, Question, quote_markdown
from graders.core.answers.reading import display_text, is_blank
from graders.core.answers.sheet import MalformedSheetError
from graders.core.contract.findings import Finding
from graders.core.contract.outcomes import Outcome
from graders.core.contract.verdict import MAX_POINTS, Diagnosis

LACKING = "Ce que vous avez coché est juste, mais il manque au moins une bonne réponse."
TOO_MANY = "Une case cochée au moins est de trop."
ALL = "toutes les bonnes réponses, et elles seules"


@dataclass(frozen=True)
class Option:
    """`why` explains, for right and wrong options alike; `misconception` names what a wrong one shows."""

    id: str
    right: bool
    text: str
    why: str
    misconception: str | None = None


@dataclass(frozen=True)
class ChoiceQuestion:
    id: str
    title: str
    text: str
    points: float
    several: bool
    hint: str
    options: tuple[Option, ...]
    section: str = ""

    @property
    def right_option_ids(self) -> list[str]:
        return [option.id for option in self.options if option.right]

    def letters(self, seed: int) -> Letters:
        return Letters.from_seed([option.id for option in self.options], seed, self.id)

    def find_option(self, name: str) -> Option:
        return next(option for option in self.options if option.id == name)


@dataclass(frozen=True)
class ChoiceSheet:
    questions: tuple[ChoiceQuestion, ...]


def make_choice_grader(exercise: str, folder: Path, sheet: ChoiceSheet) -> ChoiceGrader:
    """Return the grader of a sheet, with the misconceptions in `folder`.

    Raises MalformedSheetError, or MalformedExerciseError for the misconceptions.
    """
    for index, question in enumerate(sheet.questions):
        _check_options(question, index)
    used = {option.misconception for question in sheet.questions for option in question.options}
    catalogue = read_mistakes(folder)
    check_same_mistakes(folder, catalogue, {name for name in used if name})
    return ChoiceGrader(exercise, folder, catalogue, sheet.questions)


def _check_options(question: ChoiceQuestion, index: int) -> None:
    ids = [option.id for option in question.options]
    right = len(question.right_option_ids)
    faults = {
        "deux options ont le même nom": len(set(ids)) != len(ids),
        f"elle a plus de {MAX_LETTERS} options": len(ids) > MAX_LETTERS,
        "aucune option n’est juste": not right,
        "plusieurs options sont justes : dites « several = true »": right > 1 and not question.several,
        "toutes ses options sont justes": right == len(ids),
        "une option juste désigne une erreur": any(
            option.right and option.misconception for option in question.options
        ),
    }
    for fault, present in faults.items():
        if present:
            raise MalformedSheetError(f"question « {question.id} » : {fault}", ("question", index))


@dataclass(frozen=True, eq=False)
class ChoiceGrader(AnswersGrader):
    questions: tuple[ChoiceQuestion, ...]

    def checks(self) -> Sequence[AnswerCheck]:
        total = sum(question.points for question in self.questions)
        return [AnswerCheck(q.id, q.title, MAX_POINTS * q.points / total, q.hint or None) for q in self.questions]

    def paper(self, seed: int) -> Paper:
        pairs = zip(self.questions, self.checks(), strict=True)
        return Paper((), tuple(_make_paper_question(question, check.points, seed) for question, check in pairs))

    def right_answers(self, seed: int) -> Answers:
        return {
            question.id: _letters_of_options(question, question.right_option_ids, seed) for question in self.questions
        }

    def judge(self, answers: Answers, seed: int) -> Sequence[Finding]:
        pairs = zip(self.questions, self.checks(), strict=True)
        return [self._judge_question(q, check, answers.get(q.id), q.letters(seed)) for q, check in pairs]

    def _judge_question(self, question: ChoiceQuestion, check: AnswerCheck, raw: Any, letters: Letters) -> Finding:
        if raw is None:
            return check.blank()
        ticked = _read_ticked_options(question, raw, letters)
        if isinstance(ticked, str):
            return check.unreadable(ticked, raw)
        options = [question.find_option(name) for name in ticked]
        hits = [option for option in options if option.right]
        if set(ticked) == set(question.right_option_ids):
            return check.passed(_join_reasons(options))
        false = _choose_option_to_explain(options)
        slip = false.misconception if false else None
        share = max(0, 2 * len(hits) - len(options)) / len(question.right_option_ids) if question.several else 0.0
        return check.failed(
            "\n\n".join(self._iter_explanations(question, options, false)),
            inputs={},
            expected=ALL if question.several else "une autre réponse",
            got=", ".join(letters.by_name[name] for name in ticked),
            points=share * check.points,
            slip=slip,
        )

    def _iter_explanations(
        self, question: ChoiceQuestion, ticked: Sequence[Option], false: Option | None
    ) -> Iterator[str]:
        """Yield the message of a wrong answer, which reveals neither unticked options nor the number of right ones."""
        if false is None:
            yield LACKING
            yield _join_reasons(ticked)
            return
        yield false.why.strip()
        if question.several and len(ticked) > 1:
            yield TOO_MANY
        if false.misconception:
            yield f"Erreur reconnue : {self.catalogue[false.misconception].brief_text}"

    def _choose_diagnosis(self, findings: Sequence[Finding]) -> Diagnosis | None:
        """Return the misconception common to all wrong answers, if any; each question reports its own."""
        slips = {finding.slip for finding in findings if finding.cause is Outcome.WRONG_ANSWER}
        slip = slips.pop() if len(slips) == 1 else None
        return self.catalogue[slip].to_diagnosis if slip else None

    def wrong_answers(self) -> Iterator[tuple[str, str | None, Callable[[int], Answers]]]:
        for question in self.questions:
            for option in question.options:
                if not option.right:
                    subject = f"{question.id} : {option.id}"
                    yield subject, option.misconception, partial(self._right_answers_except, question, [option.id])
            if question.several:
                everything = [option.id for option in question.options]
                yield f"{question.id} : tout", None, partial(self._right_answers_except, question, everything)

    def _right_answers_except(self, question: ChoiceQuestion, ticked: Sequence[str], seed: int) -> Answers:
        return {**self.right_answers(seed), question.id: _letters_of_options(question, ticked, seed)}

    def replace_names_by_letters(self, answers: Answers, seed: int) -> Answers:
        return self._replace_letters(answers, lambda question: question.letters(seed).by_name)

    def translate_letters(self, answers: Answers, old: int, new: int) -> Answers:
        def letters(question: ChoiceQuestion) -> Mapping[str, str]:
            names, fresh = question.letters(old).by_letter, question.letters(new).by_name
            return {letter: fresh[name] for letter, name in names.items()}

        return self._replace_letters(answers, letters)

    def _replace_letters(self, answers: Answers, letters: Callable[[ChoiceQuestion], Mapping[str, str]]) -> Answers:
        maps = {question.id: letters(question) for question in self.questions}
        return {name: _rename_choice(value, maps.get(name, {})) for name, value in answers.items()}

    def transcribe(self, answers: Answers, seed: int) -> Sequence[AnswerTranscript]:
        return [
            _make_transcript(
                question, answers.get(question.id), {piece.id: piece for piece in _lettered_options(question, seed)}
            )
            for question in self.questions
            if not is_blank(answers.get(question.id))
        ]

    def correction(self, seed: int) -> str:
        parts = []
        for index, question in enumerate(self.questions, 1):
            parts.append(f"**{index}. {question.title}.** {question.text}")
            for letter, name in question.letters(seed).by_letter.items():
                option = question.find_option(name)
                parts.append(
                    f"{'✓' if option.right else '✗'} **{letter}.** {option.text}\n\n> {quote_markdown(option.why)}"
                )
        return "\n\n".join(parts)


def _make_paper_question(question: ChoiceQuestion, points: float, seed: int) -> Question:
    form: Form = "several" if question.several else "one"
    return Question(
        question.id,
        question.title,
        question.text,
        form,
        points,
        pieces=_lettered_options(question, seed),
        section=question.section,
    )


def _lettered_options(question: ChoiceQuestion, seed: int) -> tuple[PaperPiece, ...]:
    names = question.letters(seed).by_letter
    return tuple(PaperPiece(letter, question.find_option(name).text) for letter, name in names.items())


def _letters_of_options(question: ChoiceQuestion, names: Sequence[str], seed: int) -> str | list[str]:
    letters = sorted(question.letters(seed).by_name[name] for name in names)
    return letters if question.several else letters[0]


def _choose_option_to_explain(ticked: Sequence[Option]) -> Option | None:
    """Return the one wrong option to explain, preferably with a misconception: ticking all must not explain all."""
    false = [option for option in ticked if not option.right]
    return next((option for option in false if option.misconception), next(iter(false), None))


def _join_reasons(options: Sequence[Option]) -> str:
    return "\n\n".join(option.why.strip() for option in options)


def _read_ticked_options(question: ChoiceQuestion, raw: Any, letters: Letters) -> list[str] | str:
    """Return the names of the ticked options, or the reason why the answer cannot be read."""
    ticked = [raw] if isinstance(raw, str) else raw
    offered = ", ".join(letters.by_letter)
    if not isinstance(ticked, list) or not all(isinstance(letter, str) for letter in ticked):
        return f"on attend une lettre parmi {offered}" + (", ou une liste de lettres" if question.several else "")
    if any(letter not in letters.by_letter for letter in ticked):
        return f"une lettre n'est celle d'aucune réponse proposée (les lettres sont {offered})"
    if len(set(ticked)) != len(ticked):
        return "une même lettre est donnée deux fois"
    if len(ticked) != 1 and not question.several:
        return "une seule lettre est attendue"
    return [letters.by_letter[letter] for letter in sorted(ticked)]


def _rename_choice(value: Any, names: Mapping[str, str]) -> Any:
    return names.get(value, value) if isinstance(value, str) else rename_items(value, names)


def _make_transcript(question: ChoiceQuestion, value: Any, pieces: Mapping[str, PaperPiece]) -> AnswerTranscript:
    ids = [value] if isinstance(value, str) else value
    if isinstance(ids, list) and all(isinstance(letter, str) and letter in pieces for letter in ids):
        return AnswerTranscript(question.id, question.title, "", tuple(pieces[letter] for letter in ids))
    return AnswerTranscript(question.id, question.title, display_text(value))
