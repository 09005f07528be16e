"""What the trials of l20/mcl have in common: one observation each, their words, their drawings."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps

import numpy as np
from numpy.typing import NDArray

from graders.core.code.bench import Bench
from graders.core.code.checks import Rejection
from graders.core.compare import words as render
from graders.core.contract.findings import FigureData
from graders.core.contract.program import StudentFault
from graders.core.contract.values import Floats
from graders.l20.mcl.scenes import Step

SHOWN = 120

Protocol = Callable[[Bench], None]


def observed(function: str) -> Callable[[Protocol], Protocol]:
    """One observation for the whole trial."""

    def decorate(protocol: Protocol) -> Protocol:
        @wraps(protocol)
        def run(bench: Bench) -> None:
            try:
                protocol(bench)
            except (Rejection, StudentFault) as found:
                fault = found if isinstance(found, StudentFault) else None
                bench.observe(function, False, ok=False, fault=fault)
                raise
            bench.observe(function, True, ok=True)

        return run

    return decorate


def number(value: float) -> str:
    return render.number(float(value), 3)


def pose_text(pose: Floats) -> str:
    return f"({' ; '.join(number(c) for c in pose)})"


def thin(cloud: Floats, weights: Floats | None = None) -> Floats:
    """At most SHOWN of the particles; the heaviest ones, where they are weighed."""
    if weights is not None and len(cloud) > SHOWN:
        return np.asarray(cloud[np.sort(np.argsort(-weights)[:SHOWN])])
    return np.asarray(cloud[:: max(1, -(-len(cloud) // SHOWN))])


def cloud_figure(
    free: NDArray[np.bool_],
    scene: Step,
    after: Floats,
    title: str,
    other: Floats | None = None,
    weights: Floats | None = None,
) -> FigureData:
    return {
        "kind": "cloud",
        "free": free,
        "before": np.round(thin(scene.particles), 3),
        "after": np.round(thin(after, weights), 3),
        "truth": scene.truth,
        "other": other,
        "title": title,
    }
