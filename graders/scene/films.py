"""Replays of student programs, made on demand from the films of their gradings.

An exercise with films has a file `graders/<module>/<slug>/replays.py` that holds `REPLAYS`, by the "kind" of a film the
function that makes a replay of it. Never imported on the path of a verdict.
"""

from __future__ import annotations

import importlib
from dataclasses import replace
from typing import Any

from graders.core.contract.findings import FigureData
from graders.scene.replay import Replay
from graders.typography import french

CLOSE = 1e-9
ALT = "Animation de ce que votre code a fait dans la vérification « {title} », à côté de la référence."


def replay_of(exercise: str, data: FigureData) -> Replay:
    """Return the replay of a film recorded with a verdict of this exercise."""
    module = importlib.import_module(f"graders.{exercise.replace('/', '.')}.replays")
    replay: Replay = module.REPLAYS[data["kind"]](data)
    return replay


def wire(exercise: str, data: FigureData, title: str) -> dict[str, Any]:
    """Return the replay in the player's format, under the title of its check, without settings."""
    replay = _leading_to_its_mark(replay_of(exercise, data))
    return {"title": french(title), "alt": french(_alt(replay, title)), "parameters": [], "values": {}, **replay.wire()}


def _leading_to_its_mark(replay: Replay) -> Replay:
    """Set the frame at which it went wrong, if unset, to the first one that a chart marks as an alert."""
    if replay.wrong is not None:
        return replay
    for chart in replay.charts:
        cursor = range(len(replay.frames)) if chart.cursor is None else chart.cursor
        for mark in chart.marks:
            frame = next((k for k, x in enumerate(cursor) if x >= mark.x - CLOSE), None)
            if mark.color == "alert" and frame is not None:
                return replace(replay, wrong=frame, wrong_label=f"Aller à ce moment : {mark.label}")
    return replay


def _alt(replay: Replay, title: str) -> str:
    if replay.alt:
        return replay.alt
    shown = " ; ".join(key.label for key in replay.legend)
    return " ".join(filter(None, (ALT.format(title=title), f"On y voit : {shown}." if shown else "")))
