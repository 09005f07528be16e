"""La trousse des exercices déclarés : `np`, `rng`, et le meneur qui joue un scénario dans le processus de l'élève.

Un scénario est fait de données simples : des étapes (appels, affectations, valeurs à montrer), des lignes d'entrée, des
fichiers. Le meneur rend des données simples : une valeur par étape, et ce qui a été affiché.
"""

import builtins
import collections
import contextlib
import importlib
import io
import itertools
import marshal
import math
import os
import sys
import types
from typing import Any

import numpy as np

__all__ = ["np", "rng"]

#: Items taken of a value, characters kept of what is printed or written, levels of a value, and files.
MAX_GENERATED, MAX_PRINTED, MAX_DEPTH, MAX_FILES = 10_000, 20_000, 20, 10


def configurer(seed: int | None = None, functions: tuple[str, ...] = (), whole_program: str = "") -> dict[str, object]:
    """Les noms que le code de l'élève trouve, pour une graine ; `functions` sont jouées par le meneur.

    `whole_program` est le nom sous lequel le fichier entier est joué, s'il est un programme.
    """
    names: dict[str, object] = {"np": np, "rng": np.random.default_rng(seed)}
    names |= {"__whole_program__": whole_program} if whole_program else {}
    return {**names, "__drivers__": dict.fromkeys(functions, play)} if functions else names


def play(target: Any, packed: Any) -> Any:
    """Play a scenario on the student's file: the steps, the lines to type and the files, as `marshal` writes them.

    Return what `play_steps` does, or the values alone where nothing else is to be said.
    """
    values, printed, shown, written = play_steps(*marshal.loads(packed.tobytes()))
    return (values, printed, shown, written) if printed or shown or written else values


def play_steps(steps: Any, lines: Any = (), files: Any = ()) -> tuple[list[Any], str, str, list[Any]]:
    """Play the steps of a scenario on the student's file.

    Return the value of each, encoded; what was printed; the same with the prompts of `input` and what was typed, empty
    where it is the same; names and texts of the files that were written. An exception of the student's own class is a
    value; any other one passes.
    """
    names: dict[str, object] = {}
    desk, world = _InputsAndFiles(lines or (), dict(files)), sys.modules["solution"].__dict__
    values = []
    reads = lines is not None or files or any(kind in ("type", "file", "argv", "program") for kind, *_ in steps)
    with contextlib.ExitStack() as stack:
        if reads:
            stack.enter_context(desk.replace_input_and_open())
        stack.enter_context(contextlib.redirect_stdout(desk.screen))
        for kind, *parts in steps:
            try:
                value = _play_step(kind, parts, names, world, desk)
            except BaseException as error:
                if type(error).__module__ == "builtins":
                    raise
                values.append(("e", [base.__name__ for base in type(error).__mro__]))
                break
            values.append(_encode(value))
    printed, shown = desk.screen.texts()
    return values, printed, "" if shown == printed else shown, desk.written_files()


class _RecordedOutput(io.TextIOBase):
    """Writes what is printed to the student's output too; what `input` shows and reads is not printed."""

    def __init__(self, shown: Any) -> None:
        self._printed, self._whole, self._shown = io.StringIO(), io.StringIO(), shown

    def write(self, text: str) -> int:
        if self._printed.tell() <= MAX_PRINTED:
            self._printed.write(text)
        return self.echo(text)

    def echo(self, text: str) -> int:
        """Write what is not judged."""
        if self._whole.tell() <= MAX_PRINTED:
            self._whole.write(text)
        self._shown.write(text)
        return len(text)

    def texts(self) -> tuple[str, str]:
        return self._printed.getvalue()[:MAX_PRINTED], self._whole.getvalue()[:MAX_PRINTED]


class _InputsAndFiles:
    """What `input` and `open` give a program, and what it writes."""

    def __init__(self, lines: Any, files: Any) -> None:
        self.screen, self._files, self._open = _RecordedOutput(sys.stdout), files, list[Any]()
        self._stdin, self._new = io.StringIO(), dict[str, str]()
        self.type_lines(lines)

    def type_lines(self, lines: Any) -> None:
        self._stdin.seek(0)
        self._stdin.truncate()
        self._stdin.write("".join(f"{line}\n" for line in lines))
        self._stdin.seek(0)

    def put_file(self, name: str, text: str) -> None:
        self._files[name] = text

    def written_files(self) -> list[Any]:
        """Return names and texts of the files that were written, also of those that were not closed."""
        for file in self._open:
            file.close()
        return [(name, text[:MAX_PRINTED]) for name, text in list(self._new.items())[:MAX_FILES]]

    @contextlib.contextmanager
    def replace_input_and_open(self) -> Any:
        """Have `input` read the lines, and `open` the files."""
        before, arguments = (builtins.input, builtins.open, io.open, sys.stdin), sys.argv[1:]
        vars(builtins).update(input=self._read_line, open=self._open_file)
        vars(io).update(open=self._open_file)
        sys.stdin, self._real_open = self._stdin, before[1]
        try:
            yield
        finally:
            vars(builtins).update(input=before[0], open=before[1])
            vars(io).update(open=before[2])
            sys.stdin, sys.argv[1:] = before[3], arguments

    def _read_line(self, prompt: object = "") -> str:
        self.screen.echo(str(prompt))
        line = self._stdin.readline()
        if not line:
            raise EOFError("il n’y a plus de ligne à lire")
        self.screen.echo(line)
        return line.removesuffix("\n")

    def _open_file(self, name: Any, mode: str = "r", *args: Any, **kwargs: Any) -> Any:
        path = name if isinstance(name, (str, int)) else os.fspath(name)
        if isinstance(path, str) and mode[:1] in ("w", "a", "x"):
            start = self._files.get(path, "") if mode[0] == "a" else ""
            file = (_WrittenBytes if "b" in mode else _WrittenText)(self, path, start)
            self._open.append(file)
            return file
        if path not in self._files:
            return self._real_open(name, mode, *args, **kwargs)
        if "+" in mode:
            raise PermissionError(f"« {path} » ne peut ici qu’être lu, ou écrit")
        return io.BytesIO(self._files[path].encode()) if "b" in mode else io.StringIO(self._files[path])

    def store(self, name: str, text: str) -> None:
        self._files[name] = self._new[name] = text


class _WrittenText(io.StringIO):
    def __init__(self, desk: Any, name: str, start: str) -> None:
        super().__init__()
        self._desk, self.name = desk, name
        self.write(start)

    def flush(self) -> None:
        self._desk.store(self.name, self.getvalue())

    def close(self) -> None:
        if not self.closed:
            self.flush()
            super().close()


class _WrittenBytes(io.BytesIO):
    def __init__(self, desk: Any, name: str, start: str) -> None:
        super().__init__()
        self._desk, self.name = desk, name
        self.write(start.encode())

    def flush(self) -> None:
        self._desk.store(self.name, self.getvalue().decode("utf-8", "replace"))

    def close(self) -> None:
        if not self.closed:
            self.flush()
            super().close()


def _play_step(kind: Any, parts: Any, names: Any, world: Any, desk: Any) -> Any:
    if kind in ("type", "file"):
        (desk.type_lines if kind == "type" else desk.put_file)(*parts)
        return None
    if kind == "argv":
        sys.argv[1:] = parts[0]
        return None
    if kind == "program":
        desk.type_lines(parts[1])
        names.update(world[parts[0]]())
        return None
    return _call_or_show(kind, parts, names, world)


def _call_or_show(kind: Any, parts: Any, names: Any, world: Any) -> Any:
    if kind == "set":
        owner, _, attribute = parts[0].rpartition(".")
        setattr(_resolve(owner, names, world), attribute, _decode(parts[1], names, world))
        return None
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
    if path == "print":
        return print
    if first not in names and first not in world:
        raise NameError(f"le nom « {first} » n’existe pas dans votre programme")
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
        "b": lambda: content,
        "n": lambda: content,
        "a": lambda: np.frombuffer(content[2], content[0]).reshape(content[1]).copy(),
        "f": lambda: _make_function(content, names, world),
        "r": lambda: _look_up(content, names, world),
        "c": lambda: _call_nested(content, names, world),
    }
    return makers[tag]()


def _make_function(content: Any, names: Any, world: Any) -> Any:
    source, imports, own = content if isinstance(content, list) else (content, (), ())
    known = {"np": np, "math": math} | {name: _import_attribute(*where) for name, *where in imports}
    return eval(source, known | {name: _resolve(name, names, world) for name in own})


def _look_up(path: Any, names: Any, world: Any) -> Any:
    """Return what an author's notation names: a name of the case or of the program, or what a module holds."""
    return _import_attribute(*path) if isinstance(path, list) else _resolve(path, names, world)


def _import_attribute(module: Any, attribute: Any) -> Any:
    value = importlib.import_module(module)
    for name in attribute.split(".") if attribute else ():
        value = getattr(value, name)
    return value


def _call_nested(content: Any, names: Any, world: Any) -> Any:
    callee, args, named, base = content
    inside = {"": _decode(base[0], names, world)} if base else names
    return _look_up(f".{callee}" if base else callee, inside, world)(
        *(_decode(argument, names, world) for argument in args),
        **{name: _decode(argument, names, world) for name, argument in named},
    )


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
