"""Behaviour of programs of a declared exercise: their answers to its probes, by which equal failures are grouped."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import closing

from graders.core.code.behaviour import UNSTABLE, Behaviour, Example
from graders.core.code.stored_answers import StoredAnswer, same_answer, to_stored_answer, truncate_answers
from graders.core.compare.python_values import is_numeric, python_text
from graders.core.contract.outcomes import Outcome
from graders.core.contract.program import Programs, StudentFault
from graders.core.contract.values import Value
from graders.core.declared.declaration import DeclaredCheck
from graders.core.declared.grading import PROBE_SEED, DeclaredGrader
from graders.core.declared.judging import FailedCase, is_answered, judge
from graders.core.declared.playing import PlayedScenario, Player
from graders.core.declared.probe_answers import PROBE_DIGITS
from graders.core.declared.scenarios import Scenario


class DeclaredObserver:
    """Observes the behaviour of programs of one version of a declared exercise; the solution runs in the sandbox too.

    Has the interface of `graders.core.code.behaviour.BehaviourObserver`.
    """

    def __init__(self, grader: DeclaredGrader) -> None:
        self._grader = grader
        self._cases = grader.probe_cases()
        self._right: list[PlayedScenario] | None = None

    def observe(self, source: bytes, programs: Programs) -> Behaviour:
        """Return the behaviour of a file's program. It is launched twice; unstable answers do not count."""
        try:
            first, second = self._play_probes(source, programs), self._play_probes(source, programs)
        except StudentFault:
            return Behaviour((), is_loadable=False)
        if self._right is None:
            self._right = self._play_probes(self._grader.solution.encode(), programs)
        answers, failures = list[StoredAnswer](), dict[int, FailedCase]()
        for k, (played, repeated) in enumerate(zip(first, second, strict=True)):
            stored = _to_stored_played(played)
            answers.append(stored if same_answer(stored, _to_stored_played(repeated)) else UNSTABLE)
            failure = self._judge_probe(k, played) if answers[k] != UNSTABLE else None
            failures |= {} if failure is None else {k: failure}
        functions = dict.fromkeys(failure.case.scenario.called_program_name for failure in failures.values())
        return Behaviour(
            truncate_answers(answers),
            tuple(failures),
            tuple(functions),
            lacks_function=any(each.fault and each.fault.outcome is Outcome.MISSING_FUNCTION for each in first),
            example=self._choose_example([(self._cases[k][0], failure) for k, failure in failures.items()]),
        )

    def _play_probes(self, source: bytes, programs: Programs) -> list[PlayedScenario]:
        """Return what a file's program does with each probe. Raises StudentFault where it does not load."""
        with closing(Player(programs, source, self._grader.kit(PROBE_SEED))) as player:
            return player.start([case.scenario for _, case in self._cases])

    def _judge_probe(self, k: int, played: PlayedScenario) -> FailedCase | None:
        assert self._right is not None
        check, case = self._cases[k]
        return judge(check, case, self._right[k], played) if is_answered(self._right[k]) else None

    def _choose_example(self, failures: Sequence[tuple[DeclaredCheck, FailedCase]]) -> Example | None:
        """Return the shortest failing case, preferably without an exception."""
        if not failures:
            return None
        check, failure = min(failures, key=lambda pair: (bool(pair[1].got.raised), _text_length(pair[1].case.scenario)))
        shown = self._grader.describe_failure(check, failure).result.counterexample
        if shown is None:
            return None
        return Example(failure.case.scenario.called_program_name, shown.inputs, shown.expected, shown.got)


def _text_length(scenario: Scenario) -> int:
    return len(scenario.text())


def _to_stored_played(played: PlayedScenario) -> StoredAnswer:
    if played.fault is not None:
        return to_stored_answer(f"faute {played.fault.exception or played.fault.outcome.value}")
    written = [dict(played.written)] if played.written else []
    return tuple(_to_stored_value(value) for value in (*played.values, played.printed, *written))


def _to_stored_value(value: Value) -> StoredAnswer:
    return to_stored_answer(value if is_numeric(value) else python_text(value, PROBE_DIGITS))
