"""The corpus of hostile programs, run by whoever asks: `python -m tests.sandbox.corpus [--without-namespaces]`.

A program defines ``repondre(contexte)`` and is called twice; `contexte` tells it the limits of the live policy, paths
and processes of the host to aim at. What it is filed under is the outcome; under ``ok``, it must answer "rien": nothing
was reached. What forgers share is a kit, `outils`.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import asdict, replace
from importlib.util import find_spec
from itertools import product
from pathlib import Path
from unittest.mock import patch

import numpy as np

from server.sandbox import Kit, ProgramFault, Sandbox, Value
from server.sandbox.child import template

from .family import template_of
from .limits import FAR, only
from .users import PROJECT

HOSTILE = PROJECT / "tests" / "hostile"
PROGRAMS = sorted(HOSTILE.glob("*/*.py"))
OUTILS = (HOSTILE / "outils.py").read_text(encoding="utf-8")
POLICY = only(memory_bytes=48 << 20, frame_bytes=1 << 18, stdout_bytes=1 << 14, items=5000)
#: For what never ends: whichever limit it meets, the outcome is the same.
HURRIED = replace(POLICY, cpu_seconds=0.05, wall_seconds=0.2)
#: Seconds that a program has to end by itself, by how it is filed: those that do are not to be killed on a slow
#: machine, and the others would only be waited for.
GRACE = {"timeout": 0.05, "invalid_output": 0.1}
CLEAN = b"import numpy as np\ndef f(x):\n    return np.linalg.solve(np.add(x, x), np.ones(2))\n"
#: They ask whether a file of the machine exists, or take a handle that reads nothing: the view hides even that, and
#: Landlock, alone where there are no namespaces, does not (see the known limits of the sandbox).
NEED_A_VIEW = {"soi_dans_proc"}
#: What has a program run by the template that draws, whatever it does.
DRAWN = b"\n# matplotlib\n"


@contextmanager
def bystander() -> Iterator[int]:
    """A process of the same user, to be left in peace."""
    with subprocess.Popen([sys.executable, "-c", "import sys; sys.stdin.read()"], stdin=subprocess.PIPE) as process:
        yield process.pid
        assert process.poll() is None


def outcome(sandbox: Sandbox, path: Path, parent: int, *, drawing: bool) -> str:
    """Kind of the first fault of two calls; "ok" when both answer "rien", else what was reached.

    Raises AssertionError when the next student notices something.
    """
    filed = path.parent.name
    context: dict[str, Value] = {name: value for name, value in asdict(POLICY).items() if isinstance(value, int)}
    context |= {"projet": str(PROJECT / "pyproject.toml"), "gabarit": template.__file__, "parent": parent}
    assert os.access(str(context["projet"]), os.R_OK)
    policy = HURRIED if filed == "timeout" else POLICY
    source = path.read_bytes() + DRAWN * drawing
    try:
        with (
            patch("server.sandbox.connection.GRACE_SECONDS", GRACE.get(filed, 60.0)),
            sandbox.open(source, kit=Kit("outils"), policy=policy, drawing=drawing) as session,
        ):
            answers = [session.call("repondre", context).value for _ in range(2)]
    except ProgramFault as fault:
        return str(fault.kind)
    finally:
        _assert_unharmed(sandbox, drawing=drawing)
    return "ok" if answers == ["rien", "rien"] else f"reached: {answers}"


def _assert_unharmed(sandbox: Sandbox, *, drawing: bool) -> None:
    with sandbox.open(CLEAN + DRAWN * drawing, policy=POLICY, drawing=drawing) as session:
        assert np.asarray(session.call("f", np.eye(2)).value).tolist() == [0.5, 0.5]


def odd(sandbox: Sandbox, programs: Iterable[Path]) -> dict[str, str]:
    """The outcomes that are not those under which a program is filed, on each template there is."""
    found = {}
    with bystander() as parent:
        for path, drawing in product(programs, (False, True) if find_spec("matplotlib") else (False,)):
            what = outcome(sandbox, path, parent, drawing=drawing)
            if what != path.parent.name:
                found[f"{path.parent.name}/{path.stem}{', drawing' * drawing}"] = what
    return found


def main() -> None:
    """Prints, as JSON: the `user`, whether there are `namespaces`, how many `programs`, and what is `odd`."""
    parser = argparse.ArgumentParser(prog="python -m tests.sandbox.corpus")
    parser.add_argument("--without-namespaces", action="store_true")
    asked = None if not parser.parse_args().without_namespaces else False
    with Sandbox({"outils": OUTILS}, FAR, namespaces=asked) as sandbox:
        namespaces = template_of(sandbox).namespaces
        programs = [path for path in PROGRAMS if namespaces or path.stem not in NEED_A_VIEW]
        told = {"user": os.geteuid(), "namespaces": namespaces, "programs": len(programs)}
        print(json.dumps(told | {"odd": odd(sandbox, programs)}, ensure_ascii=False, indent=2))


if __name__ == "__main__":
    main()
