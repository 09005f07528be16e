"""What the tools of those who deploy say of the files of `server/deploy/`: each where it is installed."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from server.base.files import ROOT

DEPLOY = ROOT / "server" / "deploy"
BESIDE = str(Path(sys.executable).parent)
FOUND = os.pathsep.join([BESIDE, os.environ.get("PATH", ""), "/usr/sbin", "/sbin"])
EXTRA = "pip install 'balise[deploy]'"
UNITS = ("balise.service", "balise-worker@1.service", "balise-backup.service", "balise-backup.timer")
#: What systemd before 254 says of a key that is for the later ones.
LATER = "Unknown key 'DelegateSubgroup' in section [Service], ignoring."
#: The exposure that systemd-analyze counts, of ten: the walls need namespaces and mounts, which it counts against us.
EXPOSURE = {"balise.service": 3.0, "balise-worker@1.service": 3.0, "balise-backup.service": 1.5}

pytestmark = pytest.mark.slow


def said(name: str, package: str, *arguments: str, folder: Path = DEPLOY) -> str:
    """What a tool says, which must be content."""
    tool = shutil.which(name, path=FOUND) or pytest.skip(f"{name} is not installed ({package})")
    done = subprocess.run([tool, *arguments], cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout + done.stderr


def test_the_container_file() -> None:
    assert said("hadolint", EXTRA, "container/Containerfile").strip() == ""


def test_compose() -> None:
    said("check-jsonschema", EXTRA, "--builtin-schema", "vendor.compose-spec", "compose/compose.yaml")


@pytest.mark.parametrize("version", ["1.31", "1.34"])
def test_kubernetes(version: str) -> None:
    files = sorted(str(path) for path in (DEPLOY / "kubernetes").glob("*.yaml") if path.stem != "kustomization")
    told = said("kubernetes-validate", EXTRA, "--strict", "-k", version, *files)
    unknown = [line for line in told.splitlines() if line.startswith("WARN")]
    assert all("ScaledObject" in line for line in unknown), "the one kind that is not of Kubernetes itself"
    assert told.count("passed for resource") > 10


def test_kubernetes_is_put_together() -> None:
    whole = said("kubectl", "Debian's kubernetes-client", "kustomize", "kubernetes")
    assert whole.count("\n  namespace: balise") > 10


def test_shell() -> None:
    for name in ("container/entrypoint.sh", "compose/secrets.sh"):
        said("sh", "every Unix", "-n", name)


def test_prometheus() -> None:
    folder, package = DEPLOY / "monitoring", "Debian's prometheus"
    assert "SUCCESS" in said("promtool", package, "check", "rules", "alerts.yml", folder=folder)
    assert "SUCCESS" in said("promtool", package, "test", "rules", "alerts.test.yml", folder=folder)
    assert "SUCCESS" in said("promtool", package, "check", "config", "--syntax-only", "prometheus.yml", folder=folder)


def test_apparmor() -> None:
    assert "balise" in said("apparmor_parser", "Debian's apparmor", "-Q", "-K", "-N", "container/apparmor").split()


@pytest.fixture
def machine(tmp_path: Path) -> Path:
    """A root with the units of systemd and ours, and with the programs that ours start."""
    own = Path("/lib/systemd/system")
    if not (own / "sysinit.target").is_file():
        pytest.skip("systemd's units are not installed")
    shutil.copytree(own, tmp_path / "lib" / "systemd" / "system", symlinks=True)
    units = tmp_path / "etc" / "systemd" / "system"
    units.mkdir(parents=True)
    for path in (DEPLOY / "systemd").glob("balise*.*"):
        shutil.copy(path, units / path.name.replace("@.", "@1."))
    for name in ("opt/balise/bin/balise", "usr/bin/find"):
        program = tmp_path / name
        program.parent.mkdir(parents=True, exist_ok=True)
        program.write_text("#!/bin/sh\n")
        program.chmod(0o755)
    return tmp_path


def test_the_units_of_systemd(machine: Path) -> None:
    told = said("systemd-analyze", "Debian's systemd", "verify", "--man=no", f"--root={machine}", *UNITS)
    ours = [line for line in told.splitlines() if "balise" in line and not line.endswith(LATER)]
    assert ours == []


@pytest.mark.parametrize(("name", "most"), EXPOSURE.items())
def test_the_units_are_exposed_as_little_as_walls_allow(name: str, most: float, machine: Path) -> None:
    hundredths = round(most * 10)
    how = ("security", "--offline=true", f"--threshold={hundredths}", "--no-pager", f"--root={machine}", name)
    assert "Overall exposure level" in said("systemd-analyze", "Debian's systemd", *how)
