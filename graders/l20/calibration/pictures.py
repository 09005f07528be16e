"""The data of the figures of l20/calibration: steps with their chords and headings, and paths in the laboratory."""

from __future__ import annotations

import numpy as np

from graders.core.contract.findings import FigureData
from graders.core.contract.values import Arguments, Floats

STEPS, PATHS = "pas", "trajets"


def steps_figure(args: Arguments, expected: Floats, got: Floats | None) -> FigureData:
    shown = got is not None and bool(np.all(np.isfinite(got)))
    return {
        "kind": STEPS,
        "counted": args[0].tolist(),
        "expected": expected.tolist(),
        "got": got.tolist() if shown and got is not None else None,
    }


def paths_figure(truth: Floats, counted: Floats, corrected: Floats | None) -> FigureData:
    """Places (n, 2) from the same start, turned so that the first headings agree."""
    return {
        "kind": PATHS,
        "truth": np.round(truth[:, :2], 3).tolist(),
        "counted": np.round(counted[:, :2], 3).tolist(),
        "corrected": None if corrected is None else np.round(corrected[:, :2], 3).tolist(),
    }
