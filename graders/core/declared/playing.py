"""Playing of scenarios on a program: the solution's, a mistake's, a student's, each in processes of its own."""

from __future__ import annotations

import builtins
import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from graders.core.compare.python_values import RaisedException
from graders.core.contract.outcomes import Outcome
from graders.core.contract.program import KitSettings, PlannedCalls, Program, Programs, Reply, StudentFault
from graders.core.contract.values import Value
from graders.core.declared.scenario_values import decode_values
from graders.core.declared.scenarios import Scenario

#: Launches of one file in one grading, and faults after which its calls stop.
MAX_LAUNCHES, MAX_FAULTS = 4, 4
UNREADABLE = StudentFault(Outcome.INVALID_OUTPUT, "la fonction renvoie une valeur qui ne se lit pas")


@dataclass(frozen=True)
class PlayedScenario:
    """What a program did in one scenario: the values of its statements, what it printed; `fault` where it stopped.

    `screen` is what was printed with the prompts of `input` and what was typed; `written` are the files it wrote.
    """

    values: tuple[Value, ...] = ()
    printed: str = ""
    fault: StudentFault | None = None
    screen: str = ""
    written: Mapping[str, str] = field(default_factory=dict)

    @property
    def raised(self) -> RaisedException | None:
        """The exception with which the scenario ended."""
        if self.fault is not None:
            return RaisedException(self.fault.exception) if self.fault.exception else None
        last = self.values[-1] if self.values else None
        return last if isinstance(last, RaisedException) else None


def is_exception(name: str, expected: str) -> bool:
    """Whether an exception of this name is the expected one, or a Python exception derived from it."""
    kind, other = (getattr(builtins, each, None) for each in (name, expected))
    return issubclass(kind, other) if isinstance(kind, type) and isinstance(other, type) else name == expected


class Player:
    """Plays scenarios on the program of one file; a program that died is launched again, a few times."""

    def __init__(self, programs: Programs, source: bytes, kit: KitSettings) -> None:
        self._programs, self._source, self._kit = programs, source, kit
        self._program: Program | None = None
        self._launches = 0
        self._functions = frozenset[str]()
        self._dead: StudentFault | None = None
        self._answered: dict[int, tuple[Scenario, PlayedScenario]] = {}
        self._printed: list[str] = []

    def make_fresh_player(self) -> Player:
        """Return a player of the same file that has played nothing."""
        return Player(self._programs, self._source, self._kit)

    def start(self, scenarios: Sequence[Scenario]) -> list[PlayedScenario]:
        """Load the file and play the first scenarios, which travel with it. Raises StudentFault where it does not
        load."""
        batches = _batch_scenarios(scenarios)
        self._launches += 1
        self._program = self._programs.open(self._source, self._kit, batches)
        self._functions = self._program.functions
        played = self._play_batches(batches, len(scenarios))
        if not any(each.fault for each in played):
            pairs = zip(scenarios, played, strict=True)
            self._answered = {id(scenario): (scenario, each) for scenario, each in pairs}  # kept: an id is used again
        return played

    @property
    def functions(self) -> frozenset[str]:
        """The functions that the file defines, also once its program has died; none before it loads."""
        return self._functions

    def play(self, scenarios: Sequence[Scenario]) -> list[PlayedScenario]:
        """Return what the program does in each scenario, in order."""
        if self._dead is not None:
            return [PlayedScenario(fault=self._dead)] * len(scenarios)
        if self._program is None:
            try:
                return self.start(scenarios)
            except StudentFault as fault:
                self._dead = fault
                return [PlayedScenario(fault=fault)] * len(scenarios)
        return self._play_batches(_batch_scenarios(scenarios), len(scenarios))

    def play_again(self, scenarios: Sequence[Scenario]) -> list[PlayedScenario]:
        """Return as `play`; scenarios that `start` has played are not played again, unless one of them stopped."""
        left = [scenario for scenario in scenarios if id(scenario) not in self._answered]
        if len(left) == len(scenarios):
            return self.play(scenarios)
        played = self.play(left) if left else []
        if any(each.fault for each in played):
            return self.play(scenarios)  # how many faults end the calls depends on those before
        known = {id(scenario): each for scenario, each in zip(left, played, strict=True)}
        known |= {identity: each for identity, (_, each) in self._answered.items()}
        return [known[id(scenario)] for scenario in scenarios]

    def _play_batches(self, batches: Sequence[PlannedCalls], count: int) -> list[PlayedScenario]:
        assert self._program is not None
        played: list[list[PlayedScenario]] = [[] for _ in batches]
        for number, answers in self._program.call_batches(batches):
            played[number] += [_to_played(answer) for answer in answers]
        last = next((each.fault for batch in played for each in batch if each.fault and each.fault.fatal), None)
        if last is not None:
            self._close_dead_program(last)
        whole: list[PlayedScenario] = []
        for batch, got in zip(batches, played, strict=True):
            stopped = last or (got[-1].fault if got and got[-1].fault else UNREADABLE)
            whole += [*got, *[PlayedScenario(fault=stopped)] * (len(batch.calls) - len(got))]
        return whole[:count]

    def _close_dead_program(self, fault: StudentFault) -> None:
        """Close a dead program; another one is launched for the next scenarios, unless it died too often."""
        self.close()
        if self._launches >= MAX_LAUNCHES:
            self._dead = fault

    def stdout(self) -> str:
        """Return what the programs of this file have printed."""
        now = self._program.stdout() if self._program else ""
        return "".join([*self._printed, now])

    def close(self) -> None:
        if self._program is not None:
            self._printed.append(self._program.stdout())
            self._program.close()
            self._program = None


def _batch_scenarios(scenarios: Sequence[Scenario]) -> list[PlannedCalls]:
    return [
        PlannedCalls(function, [scenario.driver_arguments() for scenario in group], faults=MAX_FAULTS)
        for function, group in itertools.groupby(scenarios, key=lambda scenario: scenario.called_program_name)
    ]


def _to_played(answer: Reply | StudentFault) -> PlayedScenario:
    if isinstance(answer, StudentFault):
        return PlayedScenario(fault=answer)
    try:
        values, printed, screen, written = (
            answer.value if isinstance(answer.value, tuple) else (answer.value, "", "", ())
        )
        decoded, files = tuple(decode_values(values)), dict(written)
    except (TypeError, ValueError):
        return PlayedScenario(fault=UNREADABLE)
    if not all(isinstance(text, str) for text in (printed, screen, *files, *files.values())):
        return PlayedScenario(fault=UNREADABLE)
    return PlayedScenario(decoded, printed, None, screen or printed, files)
