"""Grading of answers: the base of all forms of exercise. A form defines its questions and judges each answer."""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from graders.core.answers.mistakes import Mistake
from graders.core.answers.question_paper import AnswerTranscript, Paper
from graders.core.answers.reading import UnreadableAnswersError, canonical_json, display_text, is_blank, read_answers
from graders.core.contract.findings import Finding, Judgement, make_verdict
from graders.core.contract.outcomes import Outcome
from graders.core.contract.program import Programs
from graders.core.contract.protocol import KnownSubmission, WhileNaming, no_early_verdict
from graders.core.contract.verdict import CheckResult, Counterexample, Diagnosis

Answers = Mapping[str, Any]
CHECKED_SEEDS = 25  # seeds on which `balise check` tries a known answer
NO_ANSWER = "Il n'y a pas encore de réponse à cette question."
UNKNOWN = "Ce fichier répond à des questions qui n'existent pas. Les questions sont : {names}."


@dataclass(frozen=True)
class AnswerCheck:
    """A check before any answer: its line of the verdict."""

    id: str
    title: str
    points: float
    hint: str | None = None

    @property
    def without_hint(self) -> AnswerCheck:
        """The check without its hint, for answers that show nothing of how the question was understood."""
        return replace(self, hint=None)

    def passed(self, message: str = "") -> Finding:
        return Finding(CheckResult(self.id, self.title, True, self.points, self.points, message))

    def failed(
        self,
        message: str,
        *,
        inputs: dict[str, Any] | None = None,
        expected: Any = None,
        got: Any = None,
        points: float = 0.0,
        cause: Outcome = Outcome.WRONG_ANSWER,
        slip: str | None = None,
    ) -> Finding:
        counterexample = None if inputs is None else Counterexample(inputs, expected, got)
        result = CheckResult(self.id, self.title, False, points, self.points, message, counterexample, self.hint)
        return Finding(result, cause, slip)

    def unreadable(self, reason: str, value: Any) -> Finding:
        message = f"Cette réponse n'est pas lue : {reason}."
        return self.without_hint.failed(
            message, inputs={}, expected="une réponse lisible", got=display_text(value), cause=Outcome.INVALID_OUTPUT
        )

    def blank(self) -> Finding:
        return self.without_hint.failed(NO_ANSWER, cause=Outcome.INVALID_OUTPUT)


@dataclass(frozen=True, eq=False)
class AnswersGrader(ABC):
    """Grades the answers to one exercise. The seed determines the student's variant and the verdict.

    `folder` holds its `misconceptions.toml` and its specimens.
    """

    exercise: str
    folder: Path
    catalogue: Mapping[str, Mistake]

    @abstractmethod
    def paper(self, seed: int) -> Paper:
        """Return the question paper of a variant."""

    @abstractmethod
    def checks(self) -> Sequence[AnswerCheck]:
        """Return the checks of a verdict, whose points sum to 20."""

    @abstractmethod
    def judge(self, answers: Answers, seed: int) -> Sequence[Finding]:
        """Return one finding for each check. `answers` holds known questions only; its values are any JSON."""

    @abstractmethod
    def right_answers(self, seed: int) -> Answers:
        """Return answers that get full marks."""

    @abstractmethod
    def wrong_answers(self) -> Iterator[tuple[str, str | None, Callable[[int], Answers]]]:
        """Yield answers that must be rejected: a description, the expected misconception, the answers for a seed."""

    @abstractmethod
    def transcribe(self, answers: Answers, seed: int) -> Sequence[AnswerTranscript]:
        """Return any answers in readable form."""

    @abstractmethod
    def correction(self, seed: int) -> str:
        """Return the full correction of a variant, in Markdown."""

    def grade(
        self,
        source: bytes,
        programs: Programs | None = None,
        *,
        seed: int,
        version: str,
        while_naming: WhileNaming = no_early_verdict,
    ) -> Judgement:
        """Return the judgement of a file of answers. `programs` and `while_naming` are not used: nothing runs."""
        started = time.perf_counter()
        findings = self._judge_file(source, seed)
        took = round(1000.0 * (time.perf_counter() - started), 3)
        diagnosis = self._choose_diagnosis(findings)
        return Judgement(make_verdict(self.exercise, version, seed, findings, diagnosis, timings={"total_ms": took}))

    def _judge_file(self, source: bytes, seed: int) -> Sequence[Finding]:
        try:
            answers = read_answers(source)
        except UnreadableAnswersError as error:
            reason = str(error)
            return [check.failed(reason, cause=Outcome.SYNTAX_ERROR) for check in self.checks()]
        names = [question.id for question in self.paper(seed).questions]
        unknown = sorted(answers.keys() - set(names))
        if unknown:
            message = UNKNOWN.format(names=", ".join(f"`{name}`" for name in names))
            got, wanted = display_text(", ".join(unknown)), ", ".join(names)
            return [
                check.failed(message, inputs={}, expected=wanted, got=got, cause=Outcome.INVALID_OUTPUT)
                for check in self.checks()
            ]
        return self.judge({name: value for name, value in answers.items() if not is_blank(value)}, seed)

    def _choose_diagnosis(self, findings: Sequence[Finding]) -> Diagnosis | None:
        """Return the misconception of most failed checks; the first one of several."""
        slips = Counter(finding.slip for finding in findings if finding.slip and not finding.passed)
        return self.catalogue[slips.most_common(1)[0][0]].to_diagnosis if slips else None

    def warm_up(self) -> None:
        self.grade(canonical_json(self.right_answers(0)).encode(), seed=0, version="")

    def mistake_ids(self) -> frozenset[str]:
        return frozenset(self.catalogue)

    def known_submissions(self) -> Iterator[KnownSubmission]:
        yield KnownSubmission("référence", _as_file_by_seed(self.right_answers), Outcome.OK, rounds=CHECKED_SEEDS)
        yield KnownSubmission("rien de répondu", lambda _: b"{}", Outcome.INVALID_OUTPUT, rounds=CHECKED_SEEDS)
        for subject, mistake, answers in self.wrong_answers():
            yield KnownSubmission(subject, _as_file_by_seed(answers), Outcome.WRONG_ANSWER, mistake, CHECKED_SEEDS)
        for path in sorted((self.folder / "specimens").glob("*/*.json")):
            subject = f"spécimen {path.parent.name}/{path.name}"
            yield KnownSubmission(subject, self._read_specimen(path.read_bytes()), Outcome(path.parent.name))

    def _read_specimen(self, source: bytes) -> Callable[[int], bytes]:
        """Return a specimen for a seed; specimens name options and steps as the course does, as letters vary."""

        def write(seed: int) -> bytes:
            try:
                answers = self.replace_names_by_letters(read_answers(source), seed)
            except UnreadableAnswersError:
                return source
            return canonical_json(answers).encode("utf-8", "surrogatepass") if answers is not None else source

        return write

    def replace_names_by_letters(self, answers: Answers, seed: int) -> Answers | None:
        """Translate answers from the course's names to the letters of a variant; None where nothing has a letter."""
        return None

    def fill_with_sample_numbers(self, wording: str) -> str:
        """Return a text of the sheet with the numbers of some variant."""
        return wording

    def translate_letters(self, answers: Answers, old: int, new: int) -> Answers:
        """Translate answers from the letters of one variant to those of another."""
        return answers


def _as_file_by_seed(answers: Callable[[int], Answers]) -> Callable[[int], bytes]:
    return lambda seed: canonical_json(answers(seed)).encode()
