"""Grading of answers: what every form of exercise shares. A form says what its questions are and judges each answer."""

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
from graders.core.contract.protocol import KnownSubmission
from graders.core.contract.verdict import CheckResult, Counterexample, Diagnosis

Answers = Mapping[str, Any]
CHECKED_SEEDS = 25  # seeds on which a known answer is tried by `balise check`
NO_ANSWER = "Il n'y a pas encore de réponse à cette question."
UNKNOWN = "Ce fichier répond à des questions qui n'existent pas. Les questions sont : {names}."


@dataclass(frozen=True)
class AnswerCheck:
    """What a check is, before any answer: its place in the verdict."""

    id: str
    title: str
    points: float
    hint: str | None = None

    @property
    def unaided(self) -> AnswerCheck:
        """The same without its hint, for what says nothing of how the question was understood."""
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
        return self.unaided.failed(
            message, inputs={}, expected="une réponse lisible", got=display_text(value), cause=Outcome.INVALID_OUTPUT
        )

    def blank(self) -> Finding:
        return self.unaided.failed(NO_ANSWER, cause=Outcome.INVALID_OUTPUT)


@dataclass(frozen=True, eq=False)
class AnswersGrader(ABC):
    """Grades the answers to one exercise; the same for the same seed, which also deals what the student is given.

    `folder` holds its `misconceptions.toml` and its specimens.
    """

    exercise: str
    folder: Path
    catalogue: Mapping[str, Mistake]

    @abstractmethod
    def paper(self, seed: int) -> Paper:
        """What the student is given."""

    @abstractmethod
    def checks(self) -> Sequence[AnswerCheck]:
        """The checks of a verdict, whose points sum to 20."""

    @abstractmethod
    def judge(self, answers: Answers, seed: int) -> Sequence[Finding]:
        """One finding for each check. `answers` speaks of known questions only; its values are any JSON."""

    @abstractmethod
    def right_answers(self, seed: int) -> Answers:
        """Answers that get full marks."""

    @abstractmethod
    def wrong_answers(self) -> Iterator[tuple[str, str | None, Callable[[int], Answers]]]:
        """Answers that must be rejected: what they are, the misconception that they must be named by, the answers."""

    @abstractmethod
    def transcribe(self, answers: Answers, seed: int) -> Sequence[AnswerTranscript]:
        """Answers as one reads them again, whatever they are."""

    @abstractmethod
    def correction(self, seed: int) -> str:
        """The full correction of this deal, in Markdown."""

    def grade(self, source: bytes, programs: Programs | None = None, *, seed: int, version: str) -> Judgement:
        """The verdict of a file of answers. Nothing runs: `programs` is what exercises of code need."""
        started = time.perf_counter()
        findings = self._findings(source, seed)
        took = round(1000.0 * (time.perf_counter() - started), 3)
        diagnosis = self._diagnosis(findings)
        return Judgement(make_verdict(self.exercise, version, seed, findings, diagnosis, timings={"total_ms": took}))

    def _findings(self, source: bytes, seed: int) -> Sequence[Finding]:
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

    def _diagnosis(self, findings: Sequence[Finding]) -> Diagnosis | None:
        """The misconception seen in most of the failed checks; of several, the one that was seen first."""
        slips = Counter(finding.slip for finding in findings if finding.slip and not finding.passed)
        return self.catalogue[slips.most_common(1)[0][0]].diagnosis if slips else None

    def rehearse(self) -> None:
        self.grade(canonical_json(self.right_answers(0)).encode(), seed=0, version="")

    def mistake_ids(self) -> frozenset[str]:
        return frozenset(self.catalogue)

    def known_submissions(self) -> Iterator[KnownSubmission]:
        yield KnownSubmission("référence", _written(self.right_answers), Outcome.OK, rounds=CHECKED_SEEDS)
        yield KnownSubmission("rien de répondu", lambda _: b"{}", Outcome.INVALID_OUTPUT, rounds=CHECKED_SEEDS)
        for subject, mistake, answers in self.wrong_answers():
            yield KnownSubmission(subject, _written(answers), Outcome.WRONG_ANSWER, mistake, CHECKED_SEEDS)
        for path in sorted((self.folder / "specimens").glob("*/*.json")):
            subject = f"spécimen {path.parent.name}/{path.name}"
            yield KnownSubmission(subject, self._specimen(path.read_bytes()), Outcome(path.parent.name))

    def _specimen(self, source: bytes) -> Callable[[int], bytes]:
        """Specimens name options and steps as the course does, since letters change with the seed."""

        def write(seed: int) -> bytes:
            try:
                answers = self.with_letters(read_answers(source), seed)
            except UnreadableAnswersError:
                return source
            return canonical_json(answers).encode("utf-8", "surrogatepass") if answers is not None else source

        return write

    def with_letters(self, answers: Answers, seed: int) -> Answers | None:
        """Answers given with the course's names, under the letters of a deal; None where nothing has a letter."""
        return None

    def sample(self, wording: str) -> str:
        """A text of the sheet as a student may read it: with the numbers of some deal in it."""
        return wording

    def reletter(self, answers: Answers, old: int, new: int) -> Answers:
        """Answers to one deal as answers to another, where the letters differ."""
        return answers


def _written(answers: Callable[[int], Answers]) -> Callable[[int], bytes]:
    return lambda seed: canonical_json(answers(seed)).encode()
