"""Starts the process of a template: its command, environment and configuration."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Mapping
from dataclasses import dataclass

from server.sandbox.child import codec
from server.sandbox.child.codec import Value
from server.sandbox.child.template import CONTROL_LIMITS
from server.sandbox.install import find_installation

_BOOT = (
    "import sys; sys.path.insert(0, sys.argv[1]); from child.boot import main; del sys.path[0]; "
    "main(*map(int, sys.argv[2:5]), sys.argv[5] == 'namespaces', sys.argv[6].split(), sys.argv[7:])"
)
_ENVIRONMENT = {
    **dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "BLIS_NUM_THREADS"), "1"),
    "LC_ALL": "C.UTF-8",
    "LD_BIND_NOW": "1",  # once in the template, rather than in each fork the functions that it comes to call
    "PYTHONHASHSEED": "0",  # a set of strings has the same order for every submission
}


#: A kit by its files (path → source), or by the source of the only one.
KitFiles = str | Mapping[str, str]


@dataclass(frozen=True)
class TemplateConfig:
    """Configuration of a template; `lifted` names walls left down, for the probe and the tests of the walls alone."""

    kits: Mapping[str, KitFiles]
    imports: str
    namespaces: bool
    lifted_walls: frozenset[str] = frozenset()


def launch_template_process(setting: TemplateConfig, control: int, log: int) -> subprocess.Popen[bytes]:
    """Start the first process of a template; `control` is its end of the socket, `log` its standard error."""
    configuration = _write_configuration(setting)
    try:
        return subprocess.Popen(
            _build_command(setting, control, configuration),
            env=_build_environment(setting),
            cwd="/",
            stdin=subprocess.DEVNULL,
            stdout=log,
            stderr=log,
            pass_fds=(control, configuration),
            start_new_session=True,
        )
    finally:
        os.close(configuration)


def _build_environment(setting: TemplateConfig) -> dict[str, str]:
    whole = "environment" in setting.lifted_walls
    return {k: v for k, v in os.environ.items() if whole or k == "LD_LIBRARY_PATH"} | _ENVIRONMENT


def _build_command(setting: TemplateConfig, control: int, configuration: int) -> list[str]:
    installed = find_installation(setting.imports)
    mode = "namespaces" if setting.namespaces else "plain"
    numbers = (str(control), str(configuration), str(os.getpid()))
    here = os.path.dirname(os.path.abspath(__file__))
    lifted = " ".join(sorted(setting.lifted_walls))
    return [installed.python, "-P", "-s", "-S", "-c", _BOOT, here, *numbers, mode, lifted, *installed.sites]


def _kit_files(name: str, files: KitFiles) -> dict[str, Value]:
    return {f"{name}.py": files} if isinstance(files, str) else dict(files)


def _write_configuration(setting: TemplateConfig) -> int:
    installed = find_installation(setting.imports)
    message: dict[str, Value] = {
        "kits": {name: _kit_files(name, files) for name, files in setting.kits.items()},
        "imports": setting.imports,
        "namespaces": setting.namespaces,
        "lifted": list(setting.lifted_walls),
        "sites": list(installed.sites),
        "packages": list(installed.packages),
    }
    descriptor = os.memfd_create("configuration", os.MFD_CLOEXEC)
    os.write(descriptor, codec.encode(message, CONTROL_LIMITS))
    os.lseek(descriptor, 0, os.SEEK_SET)
    return descriptor
