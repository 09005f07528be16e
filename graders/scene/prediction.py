"""What a reader is asked before a replay plays: a question of a few answers, told when it has played to its end."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from graders.scene.packing import SceneError
from graders.typography import french

ANSWER_ID = re.compile(r"[a-z][a-z0-9_]{0,39}")
FEWEST, MOST = 2, 6


@dataclass(frozen=True)
class Prediction:
    """`answers` are ids and their words; `right` is the id of what happens, and `why` says so, told after playing.

    `settings` are those with which the replay is then played, as an address has them (`{"fausse": "1"}`), defaults
    elsewhere. What is counted goes by the ids: a question that changes its sense takes others.
    """

    question: str
    answers: tuple[tuple[str, str], ...]
    right: str
    why: str
    settings: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        ids = [name for name, _ in self.answers]
        if not FEWEST <= len(ids) <= MOST:
            raise SceneError("answers", f"are {len(ids)}, not {FEWEST} to {MOST}")
        if len(set(ids)) != len(ids) or not all(ANSWER_ID.fullmatch(name) for name in ids):
            raise SceneError("answers", "have ids that are malformed, or given twice")
        if self.right not in ids:
            raise SceneError("right", f"« {self.right} » is not among the answers")

    def wire(self) -> dict[str, Any]:
        return {
            "question": french(self.question),
            "answers": [[name, french(words)] for name, words in self.answers],
            "right": self.right,
            "why": french(self.why),
            "settings": dict(self.settings),
        }
