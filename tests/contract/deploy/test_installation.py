"""The command that an administrator types, and the script of a release, without building one."""

from __future__ import annotations

import re
import runpy
import subprocess
import zipfile
from pathlib import Path

from server.base.files import ROOT

DEPLOY = ROOT / "server" / "deploy"


def write_script(path: Path, text: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f"#!/bin/sh\n{text}\n")
    path.chmod(0o755)


def test_the_command_has_the_settings_secrets_and_account_of_the_service(tmp_path: Path) -> None:
    write_script(tmp_path / "opt" / "balise", 'env; echo "arguments: $*"')
    write_script(tmp_path / "bin" / "runuser", 'echo "account: $2"; shift 3; exec "$@"')
    (tmp_path / "etc" / "secrets").mkdir(parents=True)
    (tmp_path / "etc" / "balise.env").write_text((DEPLOY / "systemd" / "balise.env").read_text())
    (tmp_path / "etc" / "secrets" / "database_url").write_text("postgresql://un secret\n")
    script = (DEPLOY / "systemd" / "balise.sh").read_text()
    for path, here in (("/etc/balise", "etc"), ("/opt/balise/bin/balise", "opt/balise")):
        assert path in script
        script = script.replace(path, str(tmp_path / here))
    command = ["sh", "-c", script, "balise", "admin", "create", "--name", "Ada L"]
    environment = {"PATH": f"{tmp_path}/bin:/usr/bin:/bin", "HOME": "/root"}
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    assert {
        "account: balise",
        "arguments: admin create --name Ada L",
        "BALISE_DATABASE_URL=postgresql://un secret",
        "BALISE_DATA_DIR=/var/lib/balise",
        "BALISE_TRUSTED_PROXY=127.0.0.1",
        "HOME=/var/lib/balise",
    } <= set(done.stdout.splitlines())
    unit = (DEPLOY / "systemd" / "balise.service").read_text()
    assert "User=balise" in unit
    assert "BALISE_DATA_DIR=/var/lib/balise" in unit


def test_a_release_has_what_the_image_has_and_refuses_archives_without_pages(tmp_path: Path) -> None:
    release = runpy.run_path(str(ROOT / ".ci" / "release"))
    extras = re.search(r"ARG EXTRAS=(.*)", (DEPLOY / "container" / "Containerfile").read_text())
    assert extras
    assert extras[1].split(",") == list(release["EXTRAS"])
    for name, right in (("server/static/stamp.txt", True), ("server/frontend/src/app.js", False)):
        wheel = tmp_path / "balise.whl"
        with zipfile.ZipFile(wheel, "w") as archive:
            archive.writestr(name, "")
        assert release["has_pages"](wheel) is right


def test_what_the_pages_say_to_install_is_what_a_release_gives() -> None:
    """No page sends to PyPI, where a package of this name would be somebody else's."""
    for page in (ROOT / "server" / "docs").rglob("*.md"):
        for line in re.findall(r"^.*pip install.*$", page.read_text(encoding="utf-8"), re.MULTILINE):
            assert not re.search(r"install .*[' ]balise(\[|$|')", line), f"{page.name}: {line}"
