"""What is to be drawn, as the process that draws is asked it, and the name that its picture is kept under.

The name is a digest of everything that changes the picture: what is drawn, its data, the theme, the format, and the
code and the libraries that draw it. Nothing that a visitor writes becomes a part of a path.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any, Literal

from graders.courses import COURSES
from server.base.files import ROOT, digest_files
from server.course.code import MANIPULATIONS
from server.course.models import Drawing

Form = Literal["svg", "png"]
Theme = Literal["light", "dark"]
MEDIA_TYPES = {"svg": "image/svg+xml", "png": "image/png"}
LIBRARIES = ("matplotlib", "numpy", "scipy")


@dataclass(frozen=True)
class FailureMessages:
    """Messages for a full queue and for a failed drawing."""

    crowded: str
    failed: str


FIGURE_MESSAGES = FailureMessages(
    "Beaucoup de figures se dessinent en ce moment : réessayez dans quelques secondes.",
    "Cette figure n’a pas pu être dessinée : l’incident est de notre côté. Réessayez.",
)
REPLAY_MESSAGES = FailureMessages(
    "Beaucoup d’animations se préparent en ce moment : réessayez dans quelques secondes.",
    "L’incident est de notre côté, il a été noté, et votre note n’en dépend pas.",
)


@dataclass(frozen=True)
class DrawingRequest:
    """`question` is JSON, read by `server.figures.process`."""

    payload: bytes
    key: str
    messages: FailureMessages = FIGURE_MESSAGES


#: Asks for nothing but that the process that draws be ready to.
WARM_UP_PAYLOAD = json.dumps({"kind": "warm"}).encode()


def build_lesson_figure_request(drawing: Drawing, theme: Theme) -> DrawingRequest:
    """A drawing of the texts."""
    asked = {"path": str(drawing.path), "function": drawing.function, "size": drawing.size, "theme": theme}
    return _build_drawing_request(
        "lesson", asked | {"form": "svg"}, f"{drawing_code_digest()} {module_drawings_digest(_module_folder(drawing))}"
    )


def build_verdict_figure_request(exercise: str, data: Mapping[str, Any], form: Form, theme: Theme) -> DrawingRequest:
    """A figure of a verdict, from the data that are stored with it."""
    return _build_drawing_request(
        "verdict", {"exercise": exercise, "data": data, "theme": theme, "form": form}, drawing_code_digest()
    )


def build_replay_request(exercise: str, data: Mapping[str, Any], title: str) -> DrawingRequest:
    """The replay of what a program did in the check of that title."""
    return _build_drawing_request(
        "film", {"exercise": exercise, "data": data, "title": title}, drawing_code_digest(), REPLAY_MESSAGES
    )


def _build_drawing_request(
    kind: str, parameters: Mapping[str, Any], drawing_version: str, messages: FailureMessages = FIGURE_MESSAGES
) -> DrawingRequest:
    question = json.dumps({"kind": kind, **parameters}).encode()
    return DrawingRequest(question, hashlib.sha256(drawing_version.encode() + b"\0" + question).hexdigest(), messages)


@cache
def drawing_code_digest() -> str:
    """Return a digest of the code and libraries that draw figures and replays."""
    rooms = [(name, place / name) for place in COURSES.folders for name in ("graders", "reference")]
    rooms.append(("server/figures", ROOT / "server" / "figures"))
    return " ".join((digest_files(rooms), *map(version, LIBRARIES)))


@cache
def module_drawings_digest(module_folder: Path) -> str:
    """Return a digest of a module's drawings, kit and replays."""
    return digest_files([(name, module_folder / name) for name in ("figures", "kit", MANIPULATIONS, "rejeux")])


def _module_folder(drawing: Drawing) -> Path:
    folder = drawing.path.parents[1]
    return folder.parent if folder.name == MANIPULATIONS else folder
