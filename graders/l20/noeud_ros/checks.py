"""A check on scenes: each is the life of one node; what it did is judged phase by phase, and the first failing phase
is shown again by itself."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from contextlib import nullcontext
from dataclasses import dataclass, replace

import numpy as np

from graders.core.code.bench import Bench
from graders.core.code.checks import Check, Rejection, fault_rejection
from graders.core.contract.findings import FigureData
from graders.core.contract.outcomes import Outcome
from graders.core.contract.program import StudentFault
from graders.core.contract.values import UnreadableError, Value
from graders.l20.noeud_ros.judge import Did, Log, circumstances, read_log, right
from graders.l20.noeud_ros.scenes import DEFAULT, NODE, Phase, Scene, phase, scenario

STOP, NOTHING = "un Twist nul sur /cmd_vel", "rien sur /cmd_vel"
WORDS = {
    Did.NOTHING: NOTHING,
    Did.STOPPED: STOP,
    Did.STOPPED_AT_FIRST: STOP,
    Did.MOVED: "un Twist qui n'est pas nul",
}


@dataclass(frozen=True)
class Failure:
    """A phase that a node fails, what it did, and what else is known of it; `before` phases came before it."""

    phase: Phase
    did: Did
    log: Log
    before: int


@dataclass(frozen=True, kw_only=True)
class Scenes(Check):
    """Play every scene, and judge each of its phases; `apart`, each in a process of its own, until one fails."""

    scenes: Callable[[np.random.Generator], Iterable[Scene]]
    apart: bool = False

    def run(self, bench: Bench) -> None:
        first: Failure | None = None
        for scene in self.scenes(bench.rng):
            if self.apart and first is not None:
                break
            with bench.run_with_kit(bench.kit) if self.apart else nullcontext(bench) as where:
                log = self._played(where, scene)
            dids = [log.did(number, scene.pace) for number in range(len(scene.phases))]
            rights = [right(did, stop=one.stop) for did, one in zip(dids, scene.phases, strict=True)]
            bench.observe(NODE, np.array(dids, dtype=float), ok=all(rights))
            if first is None and not all(rights):
                number = rights.index(False)
                first = self._isolated(bench, scene, number, Failure(scene.phases[number], dids[number], log, number))
        if first is not None:
            raise rejection(first)

    def _played(self, bench: Bench, scene: Scene) -> Log:
        try:
            return _log(bench, scene)
        except StudentFault as fault:
            bench.observe(NODE, None, ok=False, fault=fault)
            raise self._fault(bench, scene, fault) from fault
        except UnreadableError as error:
            raise Rejection(str(error), inputs={}, cause=Outcome.INVALID_OUTPUT) from error

    def _fault(self, bench: Bench, scene: Scene, fault: StudentFault) -> Rejection:
        """The first phase on which it fails alone."""
        again = () if bench.runner.reenacting or fault.fatal or fault.exception is None else range(len(scene.phases))
        for number in again:
            alone = scene.alone(number)
            try:
                _log(bench, alone)
            except StudentFault as same:
                if same.exception != fault.exception:
                    break
                shown = alone.phases[0]
                return fault_rejection(same, inputs=given(shown), expected=STOP if shown.stop else NOTHING)
            except UnreadableError:
                break
        return fault_rejection(fault, inputs={})

    def _isolated(self, bench: Bench, scene: Scene, number: int, failure: Failure) -> Failure:
        """The same failure on this phase alone, and on a plainer scan, where it is still there."""
        if bench.runner.reenacting:
            return failure
        alone = _again(bench, scene.alone(number), failure)
        if alone is None:
            return failure
        plainer = _again(bench, Scene([_plainer(failure.phase)], scene.alone(number).launched), failure)
        return plainer or alone


def _log(bench: Bench, scene: Scene) -> Log:
    return read_log(bench.call(NODE, scenario(scene)))


def _again(bench: Bench, scene: Scene, failure: Failure) -> Failure | None:
    try:
        log = _log(bench, scene)
    except (StudentFault, UnreadableError):
        return None
    did = log.did(0, scene.pace)
    return Failure(scene.phases[0], did, log, 0) if WORDS[did] == WORDS[failure.did] else None


def _plainer(one: Phase) -> Phase:
    """All that is far reads 5 m."""
    far = np.isfinite(one.ranges) & (one.ranges > max(1.0, one.distance)) & (one.ranges < one.range_max)
    ranges = np.where(far, min(5.0, 0.9 * one.range_max), one.ranges)
    return replace(
        phase(ranges, one.told, distance=one.distance, angle_min=one.angle_min),
        range_min=one.range_min,
        range_max=one.range_max,
        stop=one.stop,
    )


def given(one: Phase) -> dict[str, Value]:
    """What the node was shown."""
    return {
        "scan.ranges": one.ranges,
        "scan.range_min": one.range_min,
        "scan.range_max": one.range_max,
        "scan.angle_min": one.angle_min,
        "distance_min": one.distance,
    }


def rejection(failure: Failure) -> Rejection:
    one, did = failure.phase, failure.did
    wanted = STOP if one.stop else NOTHING
    got = WORDS[did]
    if one.stop and did is Did.NOTHING:
        happened = "votre nœud n'y publie rien"
    elif did is Did.MOVED:
        happened = "votre nœud y publie une vitesse qui n'est pas nulle : ce n'est pas à lui de faire rouler le robot"
    else:
        happened = "votre nœud y publie un arrêt"
    setting = (
        ""
        if one.distance == DEFAULT or "distance_min" in one.told
        else f" (distance_min : {one.distance:g} m)".replace(".", ",")
    )
    earlier = f" C'est la situation n° {failure.before + 1} de la même vie du nœud." if failure.before else ""
    message = f"Scan de {len(one.ranges)} rayons : {one.told}{setting}. On attend {wanted}, et {happened}."
    return Rejection(
        message + circumstances(failure.log) + earlier,
        inputs=given(one),
        expected=wanted,
        got=got,
        figure=figure(one, got),
    )


def figure(one: Phase, got: str) -> FigureData:
    return {
        "kind": "scan",
        "ranges": [value if np.isfinite(value) else str(value) for value in one.ranges.tolist()],
        "range_min": one.range_min,
        "range_max": one.range_max,
        "distance": one.distance,
        "expected": STOP if one.stop else NOTHING,
        "got": got,
    }
