"""Parameters of a replay that readers change: each parses its value from a URL, or gives a reason in French."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

from graders.typography import french
from reference.se2 import wrap_angle

NUMBER = re.compile(r"-?[0-9]{1,9}(\.[0-9]{1,9})?")
Pose = tuple[float, float, float]
Value = float | int | bool | str | Pose | None
#: Names of choices, each with those of its values with which a setting acts: it is not shown with the others.
OnlyWith = Mapping[str, tuple[str, ...]]


class RefusedError(Exception):
    """A value that a parameter does not take; the message says why, in French."""


class Parameter(Protocol):
    """`default` is the value of a reader who changed nothing."""

    @property
    def label(self) -> str: ...

    @property
    def default(self) -> Value: ...

    def read(self, text: str) -> Value:
        """Return the value of a URL parameter, rounded to its step. Raises RefusedError."""

    def describe(self) -> dict[str, Any]:
        """Return the description from which the browser shows it."""


def _condition(only_with: OnlyWith) -> dict[str, Any]:
    return {"onlyWith": {name: list(values) for name, values in only_with.items()}} if only_with else {}


def _number(text: str) -> float:
    if not NUMBER.fullmatch(text):
        raise RefusedError("un nombre est attendu, écrit avec un point décimal")
    return float(text)


def _within(value: float, least: float, high: float) -> float:
    if not least <= value <= high:
        raise RefusedError(f"la valeur doit être comprise entre {least:g} et {high:g}".replace(".", ","))
    return value


def decimals_of(number: float) -> int:
    """Return the number of decimals of a number, at most 6."""
    return len(f"{number:.6f}".rstrip("0").partition(".")[2])


def on_step(value: float, least: float, step: float) -> float:
    """Return the nearest value `least` + k `step`."""
    return round(least + step * round((value - least) / step), decimals_of(step) + 2)


@dataclass(frozen=True)
class Slider:
    """A number in [least, most] by steps of `step`; whole when all of these are. `only_with`: with what it acts."""

    label: str
    least: float
    most: float
    step: float
    default: float
    unit: str = ""
    only_with: OnlyWith = field(default_factory=dict)

    def __post_init__(self) -> None:
        assert self.least <= self.default <= self.most, self.label
        assert self.least < self.most, self.label
        assert self.step > 0.0, self.label

    @property
    def whole(self) -> bool:
        return all(float(part).is_integer() for part in (self.least, self.step))

    def read(self, text: str) -> Value:
        value = on_step(_within(_number(text), self.least, self.most), self.least, self.step)
        value = min(value, self.most)
        return int(value) if self.whole else float(value)

    def describe(self) -> dict[str, Any]:
        decimals = 0 if self.whole else max(decimals_of(self.step), decimals_of(self.least))
        return {"kind": "slider", "least": self.least, "most": self.most, "step": self.step, "unit": self.unit,
                "decimals": decimals, **_condition(self.only_with)}  # fmt: skip


@dataclass(frozen=True)
class Choice:
    """One of the `options`, as pairs (value in the address, label). `only_with`: with what it acts."""

    label: str
    options: tuple[tuple[str, str], ...]
    default: str
    only_with: OnlyWith = field(default_factory=dict)

    def __post_init__(self) -> None:
        assert self.default in dict(self.options), self.label

    def read(self, text: str) -> Value:
        if text not in dict(self.options):
            raise RefusedError(f"les valeurs possibles sont {', '.join(value for value, _ in self.options)}")
        return text

    def describe(self) -> dict[str, Any]:
        options = [[value, french(label)] for value, label in self.options]
        return {"kind": "choice", "options": options, **_condition(self.only_with)}


@dataclass(frozen=True)
class Switch:
    """On or off, 1 or 0 in the address."""

    label: str
    default: bool = False

    def read(self, text: str) -> Value:
        if text not in ("0", "1"):
            raise RefusedError("les valeurs possibles sont 0 et 1")
        return text == "1"

    def describe(self) -> dict[str, Any]:
        return {"kind": "switch"}


@dataclass(frozen=True)
class Event:
    """A button: something happens at the step that is shown when it is pressed, among `steps`; -1 is never."""

    label: str
    undo: str
    steps: int
    default: int | None = None

    def read(self, text: str) -> Value:
        step = int(_within(_number(text), -1, self.steps - 1))
        return None if step < 0 else step

    def describe(self) -> dict[str, Any]:
        return {"kind": "event", "undo": french(self.undo), "steps": self.steps}


@dataclass(frozen=True)
class Draw:
    """« Nouveau tirage »: another seed."""

    label: str = "Nouveau tirage"
    count: int = 100
    default: int = 0

    def read(self, text: str) -> Value:
        return int(_within(_number(text), 0, self.count - 1))

    def describe(self) -> dict[str, Any]:
        return {"kind": "draw", "count": self.count}


@dataclass(frozen=True)
class Dragged:
    """A pose that the reader drags on the drawing: "x,y,theta", within `box` = (x0, y0, x1, y1). A place that does not
    turn keeps its angle."""

    label: str
    default: Pose
    box: tuple[float, float, float, float]
    step: float = 0.05
    turn: float = math.pi / 90.0
    turns: bool = True

    def read(self, text: str) -> Value:
        parts = text.split(",")
        if len(parts) != 3:
            raise RefusedError("trois nombres sont attendus : x, y et l’angle")
        x, y, theta = (_number(part) for part in parts)
        x0, y0, x1, y1 = self.box
        x, y = _within(x, x0, x1), _within(y, y0, y1)
        angle = wrap_angle(self.turn * round(_within(theta, -100.0, 100.0) / self.turn))
        return min(on_step(x, x0, self.step), x1), min(on_step(y, y0, self.step), y1), round(float(angle), 6)

    def describe(self) -> dict[str, Any]:
        return {"kind": "pose", "box": list(self.box), "step": self.step, "turn": self.turn, "turns": self.turns}


@dataclass(frozen=True)
class Values:
    """The values of one reader's settings, by name."""

    by_name: Mapping[str, Value]

    def number(self, name: str) -> float:
        value = self.by_name[name]
        assert isinstance(value, int | float)
        return float(value)

    def whole(self, name: str) -> int:
        value = self.by_name[name]
        assert isinstance(value, int)
        return value

    def flag(self, name: str) -> bool:
        return self.by_name[name] is True

    def choice(self, name: str) -> str:
        return str(self.by_name[name])

    def event(self, name: str) -> int | None:
        """The step of an event; None when it does not happen."""
        value = self.by_name[name]
        assert value is None or isinstance(value, int)
        return value

    def pose(self, name: str) -> Pose:
        value = self.by_name[name]
        assert isinstance(value, tuple)
        return value
