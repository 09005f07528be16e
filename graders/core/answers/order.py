"""The steps of a proof to be put in order, among distractors that are to be left aside."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from graders.core.answers.chain import Predecessors, find_transitive_predecessors, longest_chain
from graders.core.answers.judging import AnswerCheck, Answers, AnswersGrader
from graders.core.answers.letters import MAX_LETTERS, Letters, rename_items
from graders.core.answers.mistakes import check_same_mistakes, read_mistakes
from graders.core.answers.question_paper import AnswerTranscript, Paper, PaperPiece, Question, quote_markdown
from graders.core.answers.reading import display_text, is_blank
from graders.core.answers.sheet import MalformedSheetError
from graders.core.contract.findings import Finding

ORDER = "ordre"  # the name of the only question
STEPS = AnswerCheck("etapes", "Les bonnes étapes, sans intrus", 8)
CHAIN = AnswerCheck("ordre", "Chaque étape après celles dont elle a besoin", 12)


@dataclass(frozen=True)
class ProofStep:
    """`role` is its purpose in the proof; `after` are the steps that must precede it."""

    id: str
    text: str
    role: str
    after: tuple[str, ...]


@dataclass(frozen=True)
class Distractor:
    """A false step; `why` explains the error."""

    id: str
    text: str
    why: str
    misconception: str | None = None


@dataclass(frozen=True)
class OrderSheet:
    instruction: str
    steps: tuple[ProofStep, ...]
    distractors: tuple[Distractor, ...]

    @property
    def pieces(self) -> tuple[ProofStep | Distractor, ...]:
        return (*self.steps, *self.distractors)


def make_order_grader(exercise: str, folder: Path, sheet: OrderSheet) -> OrderGrader:
    """Return the grader of a sheet, with the misconceptions in `folder`.

    Raises MalformedSheetError, or MalformedExerciseError for the misconceptions.
    """
    names = [piece.id for piece in sheet.pieces]
    steps = names[: len(sheet.steps)]
    for index, distractor in enumerate(sheet.distractors):
        if distractor.id in steps:
            raise MalformedSheetError(f"une étape et un intrus se nomment « {distractor.id} »", ("distractor", index))
    if len(set(names)) != len(names):
        raise MalformedSheetError("deux étapes ont le même nom")
    if len(names) > MAX_LETTERS:
        raise MalformedSheetError(f"il y a plus de {MAX_LETTERS} étapes")
    for index, step in enumerate(sheet.steps):
        unknown = set(step.after) - set(steps[:index])
        if unknown:
            message = f"étape « {step.id} » : {', '.join(sorted(unknown))} n’est pas une étape écrite au-dessus"
            raise MalformedSheetError(message, ("step", index, "after"))
    catalogue = read_mistakes(folder)
    check_same_mistakes(
        folder, catalogue, {distractor.misconception for distractor in sheet.distractors if distractor.misconception}
    )
    return OrderGrader(exercise, folder, catalogue, sheet)


@dataclass(frozen=True, eq=False)
class OrderGrader(AnswersGrader):
    sheet: OrderSheet

    def checks(self) -> Sequence[AnswerCheck]:
        return (STEPS, CHAIN)

    def letters(self, seed: int) -> Letters:
        return Letters.from_seed([piece.id for piece in self.sheet.pieces], seed, ORDER)

    def paper(self, seed: int) -> Paper:
        question = Question(
            ORDER,
            "L'ordre des étapes",
            self.sheet.instruction,
            "order",
            20.0,
            pieces=tuple(self._pieces_by_letter(seed).values()),
        )
        return Paper((), (question,))

    def _pieces_by_letter(self, seed: int) -> dict[str, PaperPiece]:
        texts = {piece.id: piece.text for piece in self.sheet.pieces}
        return {letter: PaperPiece(letter, texts[name]) for letter, name in self.letters(seed).by_letter.items()}

    def right_answers(self, seed: int) -> Answers:
        return self._answers_of_steps([step.id for step in self.sheet.steps], seed)

    def _answers_of_steps(self, names: Sequence[str], seed: int) -> Answers:
        return {ORDER: [self.letters(seed).by_name[name] for name in names]}

    def judge(self, answers: Answers, seed: int) -> Sequence[Finding]:
        raw = answers.get(ORDER)
        if raw is None:
            return [check.blank() for check in self.checks()]
        letters = self.letters(seed)
        names = _read_step_names(raw, letters)
        if isinstance(names, str):
            return [check.unreadable(names, raw) for check in self.checks()]
        return [self._judge_steps(names, letters), self._judge_chain(names, letters)]

    def _judge_steps(self, names: Sequence[str], letters: Letters) -> Finding:
        distractors = {distractor.id: distractor for distractor in self.sheet.distractors}
        false = [distractors[name] for name in names if name in distractors]
        lacking = len(self.sheet.steps) - (len(names) - len(false))
        if not false and not lacking:
            return STEPS.passed()
        share = 1.0 - lacking / len(self.sheet.steps) - len(false) / max(1, len(distractors))
        first = false[0] if false else None
        return STEPS.failed(
            first.why.strip() if first else "Il manque des étapes.",
            inputs={},
            expected="des étapes toutes justes, et aucune qui manque",
            got=f"l'étape {letters.by_name[first.id]}, qui est un intrus" if first else _letters_text(names, letters),
            points=max(0.0, share) * STEPS.points,
            slip=next((distractor.misconception for distractor in false if distractor.misconception), None),
        )

    def _judge_chain(self, names: Sequence[str], letters: Letters) -> Finding:
        """Mark the longest subsequence in a right order, whatever is false or missing in between.

        The message gives the kind of fault only: with the step or its position, one could solve by trial.
        """
        before = find_transitive_predecessors({step.id: step.after for step in self.sheet.steps})
        true = [name for name in names if name in before]
        wanted, length = len(before), longest_chain(true, before)
        if length == wanted:
            return CHAIN.passed()
        share = max(0, length - 1) / (wanted - 1)  # a step alone is no chain
        return CHAIN.failed(
            " ".join(_iter_order_faults(true, before, length)),
            inputs={},
            expected="chaque étape après toutes celles qu'elle utilise",
            got=_letters_text(names, letters),
            points=share * CHAIN.points,
        )

    def wrong_answers(self) -> Iterator[tuple[str, str | None, Callable[[int], Answers]]]:
        names = [step.id for step in self.sheet.steps]
        for distractor in self.sheet.distractors:
            for position in (0, len(names) // 2, len(names)):
                with_distractor = [*names[:position], distractor.id, *names[position:]]
                subject = f"intrus {distractor.id}, place {position + 1}"
                yield subject, distractor.misconception, partial(self._answers_of_steps, with_distractor)
        yield "à l'envers", None, partial(self._answers_of_steps, names[::-1])
        yield "sans la fin", None, partial(self._answers_of_steps, names[:-1])

    def replace_names_by_letters(self, answers: Answers, seed: int) -> Answers:
        return {name: rename_items(value, self.letters(seed).by_name) for name, value in answers.items()}

    def translate_letters(self, answers: Answers, old: int, new: int) -> Answers:
        fresh = self.letters(new).by_name
        letters = {letter: fresh[name] for letter, name in self.letters(old).by_letter.items()}
        return {name: rename_items(value, letters) for name, value in answers.items()}

    def transcribe(self, answers: Answers, seed: int) -> Sequence[AnswerTranscript]:
        value, pieces = answers.get(ORDER), self._pieces_by_letter(seed)
        if is_blank(value):
            return []
        if isinstance(value, list) and all(isinstance(letter, str) and letter in pieces for letter in value):
            return [AnswerTranscript(ORDER, "Vos étapes, dans l'ordre", "", tuple(pieces[letter] for letter in value))]
        return [AnswerTranscript(ORDER, "Vos étapes, dans l'ordre", display_text(value))]

    def correction(self, seed: int) -> str:
        letters = self.letters(seed).by_name
        steps = [
            f"**{index}.** ({letters[step.id]}) {step.text.strip()}\n\n> Ici, il faut {quote_markdown(step.role)}"
            for index, step in enumerate(self.sheet.steps, 1)
        ]
        false = [
            f"✗ ({letters[distractor.id]}) {distractor.text.strip()}\n\n> {quote_markdown(distractor.why)}"
            for distractor in self.sheet.distractors
        ]
        return "\n\n".join([*steps, *(["**Les intrus**"] if false else []), *false])


def _iter_order_faults(true: Sequence[str], before: Predecessors, length: int) -> Iterator[str]:
    """Yield one sentence for each kind of fault in the order of the true steps."""
    if not true:
        yield "Aucune étape de la démonstration n'est placée."
        return
    if before[true[0]]:
        yield "Le départ n'en est pas un : la première étape s'appuie déjà sur une autre."
    if length < len(true):
        yield "Une étape au moins vient trop tôt : elle utilise un résultat que vous n'établissez que plus bas."
    if len(true) < len(before):
        last = list(before)[-1]
        yield (
            "La démonstration n'arrive pas à sa conclusion."
            if last not in true
            else "La démonstration a un trou : une étape au moins s'appuie sur ce que rien n'établit."
        )
    if length > 1:
        yield f"Au mieux, {length} étapes sur {len(before)} s'enchaînent bien."


def _read_step_names(raw: Any, letters: Letters) -> list[str] | str:
    """Return the names of the steps in the order of the answer, or the reason why it cannot be read."""
    if not isinstance(raw, list) or not all(isinstance(letter, str) for letter in raw):
        return "on attend la liste des lettres des étapes, dans l'ordre"
    if any(letter not in letters.by_letter for letter in raw):
        return "une lettre n'est celle d'aucune étape proposée"
    if len(set(raw)) != len(raw):
        return "une même étape est placée deux fois"
    return [letters.by_letter[letter] for letter in raw]


def _letters_text(names: Sequence[str], letters: Letters) -> str:
    return ", ".join(letters.by_name[name] for name in names)
