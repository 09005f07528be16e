"""The proxies' example files, as they are written, before a real service: by a name of its own, and under a path."""

from __future__ import annotations

import os
import re
import shutil
import socket
import ssl
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import httpx
import pytest

from server.base.files import ROOT
from server.base.settings import Settings
from tests.support.live import PASSWORD, Live, balise, until

PROXIES = ROOT / "server" / "deploy" / "proxy"
FOUND = os.pathsep.join([os.environ.get("PATH", ""), "/usr/sbin", "/sbin"])
CERTIFICATE = (
    "openssl req -x509 -newkey rsa:2048 -nodes -days 2 -subj /CN=localhost -addext subjectAltName=IP:127.0.0.1"
)
PATIENCE = 300.0  # seconds, against hanging alone: each wait ends by what it waits for
MAIN = """daemon off; user root; pid {folder}/pid; error_log stderr; worker_processes 1; events {{}}
http {{
    access_log off;
    {temp}
    {site}
}}
"""
TEMP = ("client_body", "proxy", "fastcgi", "uwsgi", "scgi")

pytestmark = [pytest.mark.slow, pytest.mark.long]


@dataclass(frozen=True)
class Place:
    """Where the service stands: port and certificate of the proxy, port of the service, the path that it is given."""

    folder: Path
    port: int
    behind: int
    path: str


def nginx(place: Place) -> list[str]:
    conf = PROXIES / "nginx"
    (place.folder / "snippets").mkdir()
    shutil.copy(conf / "proxy.conf", place.folder / "snippets" / "balise-proxy.conf")
    site = (conf / "balise.conf").read_text(encoding="utf-8")
    if place.path:
        under = (conf / "balise-under-a-path.conf").read_text(encoding="utf-8")
        site = re.sub(r"    location / \{.*?\n    \}\n", lambda _: under, site, flags=re.DOTALL)
    site = re.sub(r"server \{\n    listen 80;.*?\n\}\n", "", site, flags=re.DOTALL).replace(
        "listen [::]:443 ssl http2;", ""
    )
    for written, here in (
        ("listen 443", f"listen 127.0.0.1:{place.port}"),
        ("/etc/ssl/balise", str(place.folder)),
        ("127.0.0.1:8000", f"127.0.0.1:{place.behind}"),
    ):
        assert written in site
        site = site.replace(written, here)
    temp = "".join(f"{name}_temp_path {place.folder}/{name};" for name in TEMP)
    (place.folder / "nginx.conf").write_text(MAIN.format(folder=place.folder, temp=temp, site=site))
    return [tool("nginx"), "-p", str(place.folder), "-c", str(place.folder / "nginx.conf")]


def caddy(place: Place) -> list[str]:
    text = (PROXIES / "Caddyfile").read_text(encoding="utf-8")
    mine, other = ("lycee.example", "balise.example") if place.path else ("balise.example", "lycee.example")
    text = re.sub(rf"^{re.escape(other)} \{{.*?^\}}\n", "", text, flags=re.DOTALL | re.MULTILINE)
    files = f"tls {place.folder}/fullchain.pem {place.folder}/privkey.pem"
    text = text.replace(f"{mine} {{", f"https://127.0.0.1:{place.port} {{\n\t{files}")
    text = text.replace("127.0.0.1:8000", f"127.0.0.1:{place.behind}")
    (place.folder / "Caddyfile").write_text(f"{{\n\tadmin off\n\tauto_https disable_redirects\n}}\n{text}")
    return [tool("caddy"), "run", "--adapter", "caddyfile", "--config", str(place.folder / "Caddyfile")]


def tool(name: str) -> str:
    return shutil.which(name, path=FOUND) or pytest.skip(f"{name} is not installed (Debian's package of this name)")


@contextmanager
def running(command: list[str], place: Place) -> Iterator[None]:
    home = {"XDG_DATA_HOME": str(place.folder), "XDG_CONFIG_HOME": str(place.folder), "HOME": str(place.folder)}
    log = place.folder / "proxy.log"
    with log.open("w") as errors:
        process = subprocess.Popen(command, stderr=errors, stdout=errors, env={**os.environ, **home})
    try:
        until(lambda: listens(place.port) or process.poll() is not None, "the proxy listens")
        assert process.poll() is None, log.read_text()
        yield
    finally:
        process.kill()  # told to end, Caddy waits for the streams that are open
        process.wait(PATIENCE)


def listens(port: int) -> bool:
    with socket.socket() as one:
        return one.connect_ex(("127.0.0.1", port)) == 0


def free_port() -> int:
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return int(one.getsockname()[1])


@pytest.mark.parametrize("path", ["", "/balise"], ids=["a name", "a path"])
@pytest.mark.parametrize("proxy", [nginx, caddy], ids=["nginx", "caddy"])
def test_the_service_works_behind_the_proxy_as_its_example_has_it(proxy: object, path: str, tmp_path: Path) -> None:
    assert callable(proxy)
    tool(proxy.__name__)
    folder = tmp_path / "proxy"
    folder.mkdir()
    keys = ["-keyout", str(folder / "privkey.pem"), "-out", str(folder / "fullchain.pem")]
    subprocess.run([*CERTIFICATE.split(), *keys], check=True, capture_output=True)
    live = Live(tmp_path / "data", BALISE_ROOT_PATH=path, BALISE_TRUSTED_PROXY="127.0.0.1", BALISE_WORKERS="1")
    try:
        behind = httpx.URL(live.address).port
        assert behind is not None
        place = Place(folder, free_port(), behind, path)
        with running(proxy(place), place):
            looked_at(live, f"https://127.0.0.1:{place.port}{path}", folder / "fullchain.pem", tmp_path)
    finally:
        live.process.terminate()
        live.process.wait(PATIENCE)
        live.close()


def looked_at(live: Live, address: str, certificate: Path, folder: Path) -> None:
    path = httpx.URL(address).path.rstrip("/")
    trusting = ssl.create_default_context(cafile=str(certificate))
    with httpx.Client(base_url=address, verify=trusting, timeout=PATIENCE) as browser:
        home = browser.get("/")
        assert home.status_code == 200
        assert f'href="{path}/classes"' in home.text
        style = re.search(r'href="([^"]+app\.css)"', home.text)
        assert style
        assert browser.get(style[1].removeprefix(path)).headers["content-type"].startswith("text/css")
        if path:
            assert browser.get(address.removesuffix("/")).url.path in {path, f"{path}/"}
        cookie = signed_up(live, browser)
        assert cookie.endswith("; Secure")
        assert f"; Path={path or '/'};" in cookie
        refused_in_french(browser, Settings.model_fields["body_bytes"].default)
        form = {"label": "essai", "password": PASSWORD}
        made = re.search(r'id="jeton">([^<]+)<', browser.post("/compte/jetons", data=form).text)
        assert made
        events_come_at_once(browser, {"Authorization": f"Bearer {made[1]}"})
    graded_by_the_command(address, made[1], certificate, folder)


def signed_up(live: Live, browser: httpx.Client) -> str:
    """The teacher's account, made by the link that the service has printed; the cookie that is set."""
    link = re.search(r"/bienvenue/\S+", live.output)
    assert link
    form = {"name": "Prof", "login": "prof", "password": PASSWORD}
    answer = browser.post(
        link[0], data=form, headers={"Origin": str(browser.base_url).rstrip("/").removesuffix("/balise")}
    )
    assert answer.status_code == 303, answer.text
    live.client.post("/connexion", data=form)
    return str(answer.headers["set-cookie"])


def refused_in_french(browser: httpx.Client, most: int) -> None:
    """What is too large for us gets to us, and our answer back; what fits is read."""
    page = "/l20/exercices/poses/soumissions"
    beyond = browser.post(page, data={"code": "x" * most}, headers={"Accept": "application/json"})
    assert (beyond.status_code, "Cette demande dépasse" in beyond.json()["detail"]) == (413, True)
    within = browser.post(page, data={"code": "x" * (most - 100)}, headers={"Accept": "application/json"})
    assert within.status_code == 413
    assert "Cette demande dépasse" not in within.json()["detail"], "it is the file that is too long, not the request"


def events_come_at_once(browser: httpx.Client, bearer: dict[str, str]) -> None:
    """A board's stream stays open: its first event comes before it ends, or never."""
    made = browser.post("/api/v1/classes", json={"name": "MPSI", "module": "l20"}, headers=bearer).json()
    events = f"/api/v1/classes/{made['id']}/events"
    with browser.stream("GET", events, headers=bearer) as answer:
        assert answer.status_code == 200
        assert next(line for line in answer.iter_lines() if line.startswith("data:"))


def graded_by_the_command(address: str, token: str, certificate: Path, folder: Path) -> None:
    """`balise submit` follows its verdict by events, through the proxy."""
    solution = ROOT / "graders" / "l20" / "poses" / "solution.py"
    arguments = ("submit", "l20/poses", str(solution), "--server", address, "--token", token)
    done = balise(*arguments, SSL_CERT_FILE=str(certificate), XDG_CONFIG_HOME=str(folder))
    assert done.returncode == 0, done.stdout + done.stderr
    assert "20" in done.stdout
