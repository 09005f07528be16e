"""Finding replays, reading a reader's settings, computing, and remembering the answers."""

from __future__ import annotations

import gzip
import hashlib
import json
import re
import zlib
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from graders.courses import module_folder
from graders.scene.hands import Start
from graders.scene.parameters import Draw, Parameter, RefusedError, Value, Values
from graders.scene.prediction import Placed, Prediction
from graders.scene.replay import Replay
from graders.typography import french
from server.base.caches import LRUCache
from server.base.errors import Invalid, NotFound
from server.course.code import MANIPULATIONS, import_file
from server.course.editions import MODULE_SLUG

NAME = re.compile(r"[a-z0-9]+(-[a-z0-9]+)*")
MEMORY_BYTES = 32 * 1024 * 1024
MAX_VALUE_LENGTH = 80  # characters, where a parameter does not say otherwise
FILE = re.compile(r"[a-z]+(-[a-z]+)*\.js")
NO_REPLAY = "Cette animation n’existe pas."
NO_MANIPULATION = "Cette manipulation n’existe pas."
#: How a manipulation's script asks for a film of its own settings (`run`, in manipulations/bench.js).
RUN_CALL = re.compile(r"\bbench\.run\(")


@dataclass(frozen=True, eq=False)
class ReplayScript:
    """A replay as its author wrote it."""

    name: str
    title: str
    alt: str
    parameters: Mapping[str, Parameter]
    compute: Callable[[Values, np.random.Generator], Replay | Start]
    prediction: Prediction | Placed | None = None

    def read(self, query: Iterable[tuple[str, str]]) -> Values:
        """The settings that an address asks for, defaults elsewhere. Raises Invalid, which names the parameter."""
        given: dict[str, Value] = {}
        for name, text in query:
            if name not in self.parameters:
                raise Invalid(f"Réglage inconnu : « {name[:MAX_VALUE_LENGTH]} ».")
            if name in given:
                raise Invalid(f"Le réglage « {name} » est donné deux fois.")
            if len(text) > getattr(self.parameters[name], "longest", MAX_VALUE_LENGTH):
                raise Invalid(f"Réglage « {name} » : valeur trop longue.")
            try:
                given[name] = self.parameters[name].read(text)
            except RefusedError as refused:
                raise Invalid(f"Réglage « {name} » : {refused}.") from refused
        return Values({name: given.get(name, parameter.default) for name, parameter in self.parameters.items()})

    def run(self, values: Values) -> dict[str, Any]:
        """The whole answer: the same for the same values."""
        seeds = [values.whole(name) for name, parameter in self.parameters.items() if isinstance(parameter, Draw)]
        rng = np.random.default_rng([zlib.crc32(self.name.encode()), *seeds])
        scene = self.compute(values, rng)
        described = [
            {"name": name, "label": french(parameter.label), **parameter.describe()}
            for name, parameter in self.parameters.items()
        ]
        head: dict[str, Any] = {"title": french(self.title), "alt": french(self.alt), "parameters": described}
        if self.prediction:
            head["prediction"] = self.prediction.wire()
        return {**head, "values": dict(values.by_name), **scene.wire()}


@dataclass(frozen=True)
class CompressedReplay:
    """JSON, compressed, and a tag that changes with it."""

    compressed: bytes
    tag: str


#: A replay, and its settings.
Key = tuple[ReplayScript, tuple[Value, ...]]


class ReplayLibrary:
    """The replays and manipulations of all courses, or of one; caches the latest answers, up to `memory_bytes`."""

    def __init__(self, curriculum: Path | None = None, memory_bytes: int = MEMORY_BYTES) -> None:
        self._curriculum = curriculum
        self._answers: LRUCache[Key, CompressedReplay] = LRUCache(memory_bytes, lambda answer: len(answer.compressed))

    def replay_names(self, module: str) -> tuple[str, ...]:
        """Return the names of a module's replays, as in URLs."""
        return list_replay_names(self._module_folder(module)) if MODULE_SLUG.fullmatch(module) else ()

    def find(self, module: str, name: str) -> ReplayScript:
        """Raises NotFound."""
        if name not in self.replay_names(module):
            raise NotFound(NO_REPLAY)
        return load_replay(self._module_folder(module), name)

    def find_manipulation(self, module: str, name: str) -> ReplayScript:
        """What a manipulation starts from, or what it asks to have computed. Raises NotFound."""
        return load_scene(self._manipulation_folder(module, name) / "scene.py", name)

    def script(self, module: str, name: str, file: str) -> str:
        """One of the scripts that follow the reader's hand. Raises NotFound."""
        path = self._manipulation_folder(module, name) / file
        if not FILE.fullmatch(file) or not path.is_file():
            raise NotFound(NO_MANIPULATION)
        return path.read_text(encoding="utf-8")

    def scripts(self, module: str, name: str) -> dict[str, str]:
        """All of them, by their names. Raises NotFound."""
        folder = self._manipulation_folder(module, name)
        return {path.name: self.script(module, name, path.name) for path in sorted(folder.glob("[!_.]*.js"))}

    def needs_no_server(self, module: str, manipulation: str) -> bool:
        """Whether a manipulation's scripts compute all by themselves once it has begun. Raises NotFound."""
        return not any(RUN_CALL.search(text) for text in self.scripts(module, manipulation).values())

    def manipulation_names(self, module: str) -> tuple[str, ...]:
        """Return the names of a module's manipulations (interactive scenes), as in URLs."""
        if not MODULE_SLUG.fullmatch(module):
            return ()
        scenes = sorted((self._module_folder(module) / MANIPULATIONS).glob("*/scene.py"))
        return tuple(path.parent.name for path in scenes if NAME.fullmatch(path.parent.name))

    def _manipulation_folder(self, module: str, name: str) -> Path:
        if name not in self.manipulation_names(module):
            raise NotFound(NO_MANIPULATION)
        return self._module_folder(module) / MANIPULATIONS / name

    def _module_folder(self, module: str) -> Path:
        return self._curriculum / module if self._curriculum else module_folder(module)

    def find_cached(self, script: ReplayScript, values: Values) -> CompressedReplay | None:
        """Return the answer to these settings where it is in the cache."""
        return self._answers.get(_cache_key(script, values))

    def compute(self, script: ReplayScript, values: Values) -> CompressedReplay:
        """Slow (tenths of a second): call it in a thread, one at a time."""
        body = json.dumps(script.run(values), ensure_ascii=False, separators=(",", ":"), allow_nan=False).encode()
        answer = CompressedReplay(gzip.compress(body, 6, mtime=0), hashlib.sha256(body).hexdigest()[:24])
        return self._answers.put(_cache_key(script, values), answer)


def _cache_key(script: ReplayScript, values: Values) -> Key:
    return script, tuple(values.by_name.values())


def list_replay_names(module: Path) -> tuple[str, ...]:
    """The names of the replays in a module's folder `rejeux`; files that begin with _ are helpers."""
    files = sorted((module / "rejeux").glob("*.py"))
    return tuple(name for path in files if NAME.fullmatch(name := path.stem.replace("_", "-")))


def load_replay(module: Path, name: str) -> ReplayScript:
    """A replay read from its file; an error in the file is raised as it is. Raises Invalid for settings of its
    question that it does not have."""
    return load_scene(module / "rejeux" / f"{name.replace('-', '_')}.py", name)


@lru_cache(maxsize=256)
def load_scene(path: Path, name: str) -> ReplayScript:
    """The same, of any file that has that form."""
    source = import_file(path)
    prediction: Prediction | Placed | None = getattr(source, "PREDICTION", None)
    script = ReplayScript(name, source.TITLE, source.ALT, dict(source.PARAMETERS), source.compute, prediction)
    script.read(prediction.settings.items() if prediction else ())
    return script
