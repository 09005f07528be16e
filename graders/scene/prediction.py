"""Questions asked before a replay plays and answered at its end: a choice, or a point to place on the drawing."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import hypot
from typing import Any

from graders.scene.packing import SceneError
from graders.typography import french

ANSWER_ID = re.compile(r"[a-z][a-z0-9_]{0,39}")
FEWEST, MOST = 2, 6
PLACE = re.compile(r"(-?[0-9]{1,4}(?:\.[0-9]{1,2})?),(-?[0-9]{1,4}(?:\.[0-9]{1,2})?)")
NEAR, FAR, AWAY = "pres", "loin", "ailleurs"

Spot = tuple[float, float]


@dataclass(frozen=True)
class Prediction:
    """`answers` are ids and texts; `right` is the id of the right one, and `why` the explanation shown after playing.

    `settings` are the URL parameters of the replay then played (`{"fausse": "1"}`), defaults elsewhere. Statistics are
    kept by id: a question whose meaning changes needs new ids.
    """

    question: str
    answers: tuple[tuple[str, str], ...]
    right: str
    why: str
    settings: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        ids = [name for name, _ in self.answers]
        if not FEWEST <= len(ids) <= MOST:
            raise SceneError("answers", f"il en faut de {FEWEST} à {MOST} ; il y en a {len(ids)}")
        if len(set(ids)) != len(ids) or not all(ANSWER_ID.fullmatch(name) for name in ids):
            raise SceneError(
                "answers", "un nom est donné deux fois, ou n’est pas fait de minuscules, chiffres et tirets"
            )
        if self.right not in ids:
            raise SceneError("right", f"« {self.right} » n’est pas l’une des réponses")

    def wire(self) -> dict[str, Any]:
        return {
            "question": french(self.question),
            "answers": [[name, french(words)] for name, words in self.answers],
            "right": self.right,
            "why": french(self.why),
            "settings": dict(self.settings),
        }


@dataclass(frozen=True)
class Placed:
    """A question answered by placing a point within `box` = (x0, y0, x1, y1) of the drawing, by steps of `step`.

    `spots` are the right positions; with several, the nearest counts. Statistics are kept by distance: up to `near`, up
    to `far`, or more, in units of the drawing (`unit`, in the singular). `up`: its y grows upwards. `settings` and
    `why` as in a Prediction. A reader's answer is stored as "x,y".
    """

    question: str
    spots: Sequence[Spot]
    box: tuple[float, float, float, float]
    near: float
    far: float
    why: str
    step: float = 0.25
    unit: str = "case"
    up: bool = False
    settings: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if not 0.0 < self.near < self.far:
            raise SceneError("near", f"{self.near} et far, {self.far} : il faut deux distances, la plus petite d’abord")
        if not self.spots or not all(self._within(x, y) for x, y in self.spots):
            raise SceneError("spots", "il en faut, et toutes dans le cadre")

    @property
    def right(self) -> str:
        return NEAR

    @property
    def answers(self) -> tuple[tuple[str, str], ...]:
        """The classes of distance, by id."""
        near, far = (f"{length:g}".replace(".", ",") for length in (self.near, self.far))
        return (
            (NEAR, f"Au plus à {near} {self._units(self.near)} de là."),
            (FAR, f"Entre {near} et {far} {self._units(self.far)}."),
            (AWAY, f"Plus loin que {far} {self._units(self.far)}."),
        )

    def distance_class(self, text: str) -> str | None:
        """Return the distance class of a stored answer; None for a text that is no point of the box."""
        match = PLACE.fullmatch(text)
        if not match or not self._within(float(match[1]), float(match[2])):
            return None
        away = min(hypot(float(match[1]) - x, float(match[2]) - y) for x, y in self.spots)
        return NEAR if away <= self.near else FAR if away <= self.far else AWAY

    def wire(self) -> dict[str, Any]:
        place = {
            "spots": [list(spot) for spot in self.spots],
            "box": list(self.box),
            "step": self.step,
            "near": self.near,
            "far": self.far,
            "unit": self.unit,
            "up": self.up,
        }
        return {
            "question": french(self.question),
            "place": place,
            "why": french(self.why),
            "settings": dict(self.settings),
        }

    def _units(self, length: float) -> str:
        return f"{self.unit}s" if length >= 2.0 and self.unit == "case" else self.unit

    def _within(self, x: float, y: float) -> bool:
        x0, y0, x1, y1 = self.box
        return x0 <= x <= x1 and y0 <= y <= y1
