"""Who enters NATS and how: token, nkey, TLS; what is wrong of them is told, and no secret goes over a wire in clear."""

from __future__ import annotations

import asyncio
import os
import shutil
import socket
import stat
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import nkeys
import pytest
from sqlalchemy import make_url

from server.base.files import ROOT
from server.base.settings import Settings
from server.database.engine import make_engine
from server.grading.job_lanes import JOB_LANES
from server.queue.jetstream import connection
from server.queue.jetstream.connection import NatsConnection
from server.queue.jetstream.credentials import NatsConfigurationError, connect_options
from server.queue.jetstream.stream_layout import build_layout
from tests.support.cluster import PATIENCE, Nats

PAGE = ROOT / "server" / "docs" / "plusieurs_machines.md"
TOKEN = "un secret"


def certificates(folder: Path) -> None:
    """`ca.pem` vouches for the server at 127.0.0.1 and for a client; `other.pem` for nobody here."""
    if shutil.which("openssl") is None:
        pytest.skip("no certificates: openssl is not installed")
    kind = ["-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes"]
    made = ["openssl", "req", "-x509", *kind, "-days", "2", "-subj", "/CN=x"]
    for name in ("ca", "other"):
        subprocess.run([*made, "-keyout", f"{name}.key", "-out", f"{name}.pem"], cwd=folder, check=True, **QUIET)
    for name in ("server", "client"):
        of = [*made, "-keyout", f"{name}.key", "-out", f"{name}.pem", "-CA", "ca.pem", "-CAkey", "ca.key"]
        extra = ["-addext", "subjectAltName=IP:127.0.0.1", "-addext", "basicConstraints=critical,CA:FALSE"]
        subprocess.run([*of, *extra], cwd=folder, check=True, **QUIET)


def make_seed_as_documented(seed: Path) -> str:
    """Run what the page says, but for the owner; return the public key that it shows."""
    lines = [line for line in PAGE.read_text().splitlines() if line.endswith(" /etc/balise/nats.seed")]
    recipe = [line for line in lines if not line.startswith("chown")]
    assert len(recipe) == 3
    script = "\n".join(recipe).replace("/etc/balise/nats.seed", str(seed))
    script = script.replace("/opt/balise/bin/python", sys.executable)
    done = subprocess.run(["sh", "-euc", script], check=True, capture_output=True, text=True)
    assert stat.S_IMODE(seed.stat().st_mode) == 0o600
    return done.stdout.strip()


QUIET = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}


@pytest.fixture(scope="module")
def guarded(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Nats]:
    """It wants a certificate of its authority, and a nkey."""
    folder = tmp_path_factory.mktemp("guarded")
    certificates(folder)
    public_key = make_seed_as_documented(folder / "seed")
    (folder / "wrong_seed").write_bytes(nkeys.encode_seed(os.urandom(32), nkeys.PREFIX_BYTE_USER))
    tls = f'tls {{ cert_file: "{folder}/server.pem", key_file: "{folder}/server.key", ca_file: "{folder}/ca.pem"'
    server = Nats(
        folder, f"{tls}, verify: true }}", f"  A: {{ jetstream: enabled, users: [{{ nkey: {public_key} }}] }}"
    )
    server.start()
    yield server
    server.stop()


@pytest.fixture(scope="module")
def by_token(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Nats]:
    server = Nats(tmp_path_factory.mktemp("token"), f'authorization {{ token: "{TOKEN}" }}', "")
    server.start()
    yield server
    server.stop()


def enters(settings: Settings, **changed: object) -> str:
    """Nothing, or why not."""
    settings = settings.model_copy(update=changed)
    with NatsConnection(settings, build_layout(settings, JOB_LANES)) as connection:
        return "" if connection.wait_first_attempt(PATIENCE) else connection.last_error


def test_a_nkey_and_a_certificate_open_what_asks_for_them(settings: Settings, guarded: Nats) -> None:
    folder = guarded.config.parent
    good = {
        "nats_url": f"tls://127.0.0.1:{guarded.port}",
        "nats_nkey_file": folder / "seed",
        "nats_tls_ca": folder / "ca.pem",
        "nats_tls_cert": folder / "client.pem",
        "nats_tls_key": folder / "client.key",
    }
    assert enters(settings, **good) == ""
    assert "Authorization" in enters(settings, **{**good, "nats_nkey_file": folder / "wrong_seed"})
    assert "certificate verify failed" in enters(settings, **{**good, "nats_tls_ca": folder / "other.pem"})
    assert enters(settings, **{**good, "nats_tls_cert": None}) != ""


def test_a_token_opens_what_asks_for_it(settings: Settings, by_token: Nats) -> None:
    url = f"nats://127.0.0.1:{by_token.port}"
    assert enters(settings, nats_url=url, nats_token=TOKEN) == ""
    assert "Authorization" in enters(settings, nats_url=url, nats_token="au hasard")


def test_no_token_is_sent_in_clear_where_tls_is_asked_for(settings: Settings) -> None:
    """To a server that says it has no TLS, as one in between would."""
    heard = bytearray()
    with socket.create_server(("127.0.0.1", 0)) as listener:
        answering = threading.Thread(target=pretend, args=(listener, heard), daemon=True)
        answering.start()
        url = f"tls://127.0.0.1:{listener.getsockname()[1]}"
        assert "does not offer TLS" in enters(settings, nats_url=url, nats_token=TOKEN)
        answering.join(PATIENCE)
    assert TOKEN.encode() not in heard


def pretend(listener: socket.socket, heard: bytearray) -> None:
    connected, _ = listener.accept()
    with connected:
        connected.settimeout(2)
        connected.sendall(b'INFO {"server_id":"x","version":"2.9.10","max_payload":1048576,"headers":true}\r\n')
        try:
            while data := connected.recv(4096):
                heard.extend(data)
        except OSError:
            return


def test_a_connection_is_left_for_good_in_the_middle_of_a_good_bye(
    settings: Settings, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A good-bye that ends as it is cut short hides that it was (`asyncio.wait_for` of Python 3.11)."""
    leaving = threading.Event()

    async def left(_client: object) -> None:
        leaving.set()
        with suppress(asyncio.CancelledError):
            await asyncio.sleep(PATIENCE)

    monkeypatch.setattr(connection, "_close_quietly", left)
    nobody = settings.model_copy(update={"nats_url": "nats://127.0.0.1:1"})
    with NatsConnection(nobody, build_layout(nobody, JOB_LANES)) as closed:
        assert leaving.wait(PATIENCE)
    assert not closed._thread.is_alive()


@pytest.mark.parametrize("variable", ["nats_nkey_file", "nats_tls_ca", "nats_tls_cert"])
def test_a_file_that_is_not_there_is_named_with_its_setting(settings: Settings, tmp_path: Path, variable: str) -> None:
    unfit = settings.model_copy(update={"nats_url": "nats://x", variable: tmp_path / "absent"})
    with pytest.raises(NatsConfigurationError, match=rf"BALISE_{variable.upper()} : \S+absent ne se lit pas"):
        connect_options(unfit)


def test_invalid_certificate_file_is_reported(settings: Settings, tmp_path: Path) -> None:
    (tmp_path / "ca.pem").write_text("bonjour")
    unfit = settings.model_copy(update={"nats_url": "nats://x", "nats_tls_ca": tmp_path / "ca.pem"})
    with pytest.raises(NatsConfigurationError, match="certificats"):
        connect_options(unfit)


def test_tls_options_of_the_database_url_reach_its_driver() -> None:
    url = Settings(database_url="postgresql://u:p@h/b?sslmode=verify-full&sslrootcert=/ca.pem").sqlalchemy_url
    _, passed = make_engine(url).dialect.create_connect_args(make_url(url))
    assert {"sslmode": "verify-full", "sslrootcert": "/ca.pem"}.items() <= passed.items()
