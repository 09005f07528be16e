"""La trousse des exercices déclarés : `np`, `rng`, et le meneur qui joue un scénario dans le processus de l'élève.

Un scénario est fait de données simples : des étapes (appels, affectations, valeurs à montrer), des lignes d'entrée, des
fichiers. Le meneur rend des données simples : une valeur par étape, et ce qui a été affiché.
"""

import builtins
import collections
import contextlib
import io
import itertools
import math
import sys
import types
from typing import Any

import numpy as np

__all__ = ["np", "rng"]

#: Items taken of a value, characters kept of what is printed, and levels of a value.
MAX_GENERATED, MAX_PRINTED, MAX_DEPTH = 10_000, 20_000, 20


def configurer(seed: int | None = None, functions: tuple[str, ...] = ()) -> dict[str, object]:
    """Les noms que le code de l'élève trouve, pour une graine ; `functions` sont jouées par le meneur."""
    names: dict[str, object] = {"np": np, "rng": np.random.default_rng(seed)}
    return {**names, "__drivers__": dict.fromkeys(functions, play)} if functions else names


def play(target: Any, steps: Any, lines: Any = (), files: Any = ()) -> tuple[list[Any], str]:
    """Play the steps of a scenario on the student's file; return the value of each, encoded, and what was printed.

    An exception of the student's own class is a value; any other one passes.
    """
    names: dict[str, object] = {}
    printed, world = io.StringIO(), sys.modules["solution"].__dict__
    values = []
    with contextlib.ExitStack() as stack:
        if lines is not None or files:
            stack.enter_context(_inputs(lines or (), dict(files)))
        stack.enter_context(contextlib.redirect_stdout(_Twice(printed, sys.stdout)))
        for kind, *parts in steps:
            try:
                value = _play_step(kind, parts, names, world)
            except BaseException as error:
                if type(error).__module__ == "builtins":
                    raise
                values.append(("e", [base.__name__ for base in type(error).__mro__]))
                break
            values.append(_encode(value))
    return values, printed.getvalue()[:MAX_PRINTED]


class _Twice(io.TextIOBase):
    """Writes what is printed to both: what is judged, and what the student is shown."""

    def __init__(self, kept: Any, shown: Any) -> None:
        self._kept, self._shown = kept, shown

    def write(self, text: str) -> int:
        if self._kept.tell() <= MAX_PRINTED:
            self._kept.write(text)
        self._shown.write(text)
        return len(text)


@contextlib.contextmanager
def _inputs(lines: Any, files: Any) -> Any:
    """Have `input` read these lines, and `open` these files."""
    remaining, real_input, real_open = iter(lines), builtins.input, builtins.open

    def read_line(prompt: object = "") -> str:
        if prompt:
            print(prompt, end="")
        try:
            return str(next(remaining))
        except StopIteration:
            raise EOFError("il n’y a plus de ligne à lire") from None

    def open_file(name: Any, mode: str = "r", *args: Any, **kwargs: Any) -> Any:
        if name not in files:
            return real_open(name, mode, *args, **kwargs)
        if "r" not in mode or "+" in mode:
            raise PermissionError(f"« {name} » ne peut qu’être lu ici")
        return io.BytesIO(files[name].encode()) if "b" in mode else io.StringIO(files[name])

    real_stdin = sys.stdin
    vars(builtins).update(input=read_line, open=open_file)
    sys.stdin = io.StringIO("".join(line + "\n" for line in lines))
    try:
        yield
    finally:
        vars(builtins).update(input=real_input, open=real_open)
        sys.stdin = real_stdin


def _play_step(kind: Any, parts: Any, names: Any, world: Any) -> Any:
    if kind == "let":
        name, value = parts
        names[name] = _decode(value, names, world)
        return None
    if kind == "show":
        return _decode(parts[0], names, world)
    into, callee, args, named = parts
    value = _resolve(callee, names, world)(
        *(_decode(argument, names, world) for argument in args),
        **{name: _decode(argument, names, world) for name, argument in named},
    )
    if into:
        names[into] = value
        return None
    return value


def _resolve(path: Any, names: Any, world: Any) -> Any:
    first, *attributes = path.split(".")
    value = names[first] if first in names else world[first]
    for attribute in attributes:
        value = getattr(value, attribute)
    return value


def _decode(value: Any, names: Any, world: Any) -> Any:
    if isinstance(value, list):
        return [_decode(item, names, world) for item in value]
    if not isinstance(value, tuple):
        return value
    tag, content = value
    makers: dict[str, Any] = {
        "t": lambda: tuple(_decode(item, names, world) for item in content),
        "s": lambda: {_decode(item, names, world) for item in content},
        "d": lambda: {_decode(key, names, world): _decode(item, names, world) for key, item in content},
        "b": lambda: bytes(content),
        "f": lambda: eval(content, {"np": np, "math": math}),
        "r": lambda: _resolve(content, names, world),
    }
    return makers[tag]()


_PLAIN = (bool, int, float, complex, str, np.ndarray, np.generic, type(None))
_LAZY: tuple[type, ...] = (types.GeneratorType, map, filter, zip, range, enumerate, type({}.keys()), type({}.values()))
_CONTAINERS = (
    ((set, frozenset), "s"),
    ((tuple,), "t"),
    (_LAZY, "g"),
)


def _encode(value: Any, depth: Any = 0) -> Any:
    if isinstance(value, _PLAIN):
        return value
    if depth > MAX_DEPTH:
        return ("o", "imbrication")
    if isinstance(value, dict):
        return ("d", [[_encode(key, depth + 1), _encode(item, depth + 1)] for key, item in value.items()])
    if isinstance(value, (bytes, bytearray)):
        return ("b", list(value[:MAX_PRINTED]))
    tag = next((tag for kinds, tag in _CONTAINERS if isinstance(value, kinds)), "")
    if tag or isinstance(value, (list, collections.deque)):
        items = [_encode(item, depth + 1) for item in itertools.islice(value, MAX_GENERATED)]
        return (tag, items) if tag else items
    return ("o", type(value).__name__)


rng = configurer()["rng"]
