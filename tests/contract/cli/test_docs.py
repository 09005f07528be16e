"""Every command of the administrators' pages is run as it is written, in the order of its page."""

from __future__ import annotations

import re
import shlex
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from server.base.files import ROOT
from server.base.settings import OTHER_VARIABLES, PREFIX, Settings
from server.cli import _build_parser, main
from server.cli.admin import ACTIONS
from server.health.metrics import COUNTERS
from server.identity.models import Role
from server.sandbox import WallReport, WallStatus
from tests.support.client import TestClient
from tests.support.cluster import Machine, nats_server
from tests.support.service import Site

DOCS = ROOT / "server" / "docs"
PAGES = sorted(DOCS.glob("*.md"))
MACHINES = "plusieurs_machines.md"
TOKEN = "un jeton de mesures"
BLOCK = re.compile(r"^```sh\n(.*?)^```$", re.DOTALL | re.MULTILINE)
SETTING = re.compile(r"((?:BALISE|OTEL)_\w+)=(\S+) (.*)")


def commands(page: Path) -> list[str]:
    return [line for block in BLOCK.findall(page.read_text(encoding="utf-8")) for line in block.splitlines()]


@pytest.fixture
def others(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """For the page that is about them: what several machines share, with a service that has begun."""
    if "--cluster" not in request.getfixturevalue("page").read_text(encoding="utf-8"):
        return
    shared = request.getfixturevalue("shared_settings")
    request.getfixturevalue("machines").append(Machine(shared).start().up())
    monkeypatch.setenv("BALISE_DATABASE_URL", shared.database_url)
    monkeypatch.setenv("BALISE_NATS_URL", shared.nats_url)


@pytest.fixture
def machine(site: Site, tmp_path: Path, others: None, monkeypatch: pytest.MonkeyPatch) -> Callable[[str], int]:
    """Runs one line as a shell would, on a machine with a database, of which the walls stand; nothing is served."""
    site.tighten(metrics_token=TOKEN)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("BALISE_DATA_DIR", str(site.settings.data_dir))
    walls = [WallReport("seccomp", WallStatus.STANDING, "refusé", required=True)]
    monkeypatch.setenv("BALISE_SMTP_HOST", "smtp.lycee.example")
    monkeypatch.setattr("server.mails.smtp.send_message", lambda *_: None)
    monkeypatch.setattr("server.cli.doctor.probe", lambda **_: walls)
    monkeypatch.setattr("server.cli.serve.serve", served)
    monkeypatch.setattr("server.cli.worker.run_worker", worked)
    monkeypatch.setattr("server.cli.worker.start_probing_walls", lambda: None)
    monkeypatch.setattr("server.cli.worker.require_safe_sandbox", lambda _: None)
    monkeypatch.setattr("server.cli.worker.logs.configure_logging", lambda *_: None)
    monkeypatch.setattr("server.cli.worker.stop_on_signals", lambda **_: None)
    monkeypatch.setenv("BALISE_TOKEN", site.token(Role.administrator)["Authorization"].removeprefix("Bearer "))
    monkeypatch.setattr("server.cli.remote.make_client", lambda _server, token: client_of(site, token))

    def run(line: str) -> int:
        setting = SETTING.fullmatch(line)
        if setting:
            with monkeypatch.context() as one:
                one.setenv(setting[1], setting[2])
                return run(setting[3])
        program, *arguments = shlex.split(line.replace("$BALISE_METRICS_TOKEN", TOKEN))
        if program == "curl":
            *header, url = arguments
            name, _, value = (header[1] if header else "Accept: */*").partition(": ")
            path = url.removeprefix("https://balise.example")
            return 0 if site.client.get(path, headers={name: value}).status_code == 200 else 22
        assert program == "balise", line
        return main(arguments)

    return run


def client_of(site: Site, token: str) -> TestClient:
    return TestClient(site.app, headers={"Authorization": f"Bearer {token}"})


def served(_settings: Settings, host: str, port: int, *_more: Any) -> int:
    assert (host, port) == ("127.0.0.1", 8000)
    return 0


def worked(settings: Settings, *_more: Any) -> None:
    assert settings.nats_url


@pytest.mark.parametrize("page", [page for page in PAGES if commands(page)], ids=lambda page: page.stem)
def test_what_a_page_says_to_run_works(page: Path, machine: Callable[[str], int], capsys: Any) -> None:
    for line in commands(page):
        assert machine(line) == 0, f"{line}\n{capsys.readouterr().err}"


def test_the_pages_tell_every_action_of_an_administrator_and_every_metric() -> None:
    said = [shlex.split(line) for page in PAGES for line in commands(page)]
    assert {words[words.index("admin") + 1] for words in said if "admin" in words} == set(ACTIONS)
    assert {words[1] for words in said if words[0] == "balise"} >= {"serve", "doctor", "backup", "restore", "admin"}
    watching = (DOCS / "surveiller.md").read_text(encoding="utf-8")
    assert all(f"`{name}_total`" in watching for name, _, _ in COUNTERS)


def test_the_configuration_of_nats_is_one(tmp_path: Path) -> None:
    (written,) = re.findall(r"```text\n(# nats.conf\n.*?)```", (DOCS / MACHINES).read_text(encoding="utf-8"), re.DOTALL)
    path = tmp_path / "nats.conf"
    path.write_text(written)
    done = subprocess.run([nats_server(), "-c", str(path), "-t"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_the_pages_name_each_other_and_real_settings() -> None:
    index = (DOCS / "README.md").read_text(encoding="utf-8")
    assert {f"{page.name}" for page in PAGES} - {"README.md"} == set(re.findall(r"\]\((\w+\.md)\)", index))
    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        assert all((DOCS / link).is_file() for link in re.findall(r"\]\(([\w./]+)\)", text))
        settings = {name.removeprefix("BALISE_").lower() for name in re.findall(r"\bBALISE_\w+", text)}
        assert settings <= {*Settings.model_fields, *(name.removeprefix(PREFIX).lower() for name in OTHER_VARIABLES)}


def test_no_command_of_a_page_stands_outside_of_what_is_run() -> None:
    """In a sentence a command is named, and nothing else: `balise doctor`."""
    run = {line for page in PAGES for line in commands(page)}
    for page in PAGES:
        for named in re.findall(r"`(balise [^`]+)`", page.read_text(encoding="utf-8")):
            assert any(line.startswith(named) for line in run), named


def of_others(page: Path) -> list[str]:
    """The commands of other programs that a page says to run, each as one line."""
    blocks = re.findall(r"^```text\n(.*?)^```$", page.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE)
    return [line for block in blocks for line in block.splitlines()]


def test_what_a_page_says_of_the_files_to_deploy_with_is_so() -> None:
    """Every file is there; every unit that is started or installed is ours, or of the program whose page it is."""
    deploy = ROOT / "server" / "deploy"
    units = {path.name.replace("@.", "@{n}.") for path in (deploy / "systemd").iterdir()}
    named, started = set(), set()
    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        named |= set(re.findall(r"server/deploy/[\w./@-]*[\w/]", text))
        started |= {
            word for line in of_others(page) for word in re.findall(r"\bbalise[\w-]*@?\w*\.(?:service|timer)", line)
        }
    assert len(named) > 12
    assert {path for path in named if not (ROOT / path).exists()} == set()
    assert {re.sub(r"@\w*\.", "@{n}.", one) for one in started} == {
        one for one in units if one.endswith(("service", "timer"))
    }


def test_a_command_of_ours_inside_another_s_is_one_of_the_command_line() -> None:
    """`docker exec … balise doctor`, `kubectl exec … -- balise admin …`."""
    inside = [
        re.search(r" exec .*?\bbalise ((?:doctor|admin|backup).*)$", line) for page in PAGES for line in of_others(page)
    ]
    found = [one[1] for one in inside if one]
    assert len(found) > 4
    for line in found:
        assert _build_parser().parse_args(shlex.split(line))
