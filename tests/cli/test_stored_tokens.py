"""`balise login`, and where `balise submit` finds its token: the flag, the environment, what was kept."""

from __future__ import annotations

import io
import json
import stat
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import httpx
import pytest

from server.base.settings import misspelt_variables
from server.cli import CommandError, main, stored_tokens
from server.cli.configuration import read_settings
from server.cli.remote import resolve_server, resolve_token
from tests.support.service import EXERCISE

SERVER = "https://balise.example"


@pytest.fixture(autouse=True)
def _settings_of_the_test_alone(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "config"))


@pytest.fixture
def tokens_seen(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Those that a server gets, which accepts the good ones alone."""
    seen: list[str] = []

    def answer(request: httpx.Request) -> httpx.Response:
        seen.append(request.headers["authorization"].removeprefix("Bearer "))
        if seen[-1].startswith("bon"):
            return httpx.Response(200, json=[])
        content = {"status": 401, "detail": "Ce jeton n’est pas valable."}
        return httpx.Response(401, json=content, headers={"content-type": "application/problem+json"})

    client = partial(httpx.Client, transport=httpx.MockTransport(answer))
    monkeypatch.setattr("server.cli.remote.httpx.Client", client)
    return seen


@pytest.fixture
def type_in(monkeypatch: pytest.MonkeyPatch) -> Callable[[str], None]:
    return lambda text: monkeypatch.setattr("sys.stdin", io.StringIO(text))


def test_a_token_that_the_server_knows_is_kept_for_its_owner_alone(
    tokens_seen: list[str], type_in: Callable[[str], None], capsys: Any
) -> None:
    type_in("  bon-jeton \n")
    assert main(["login", "--server", f"{SERVER}/"]) == 0
    assert tokens_seen == ["bon-jeton"]
    assert stored_tokens.load_tokens_by_server() == {SERVER: "bon-jeton"}
    assert stat.S_IMODE(stored_tokens.path().stat().st_mode) == 0o600
    assert stat.S_IMODE(stored_tokens.path().parent.stat().st_mode) == 0o700
    said = capsys.readouterr()
    assert "bon-jeton" not in said.out + said.err
    type_in("bon-autre\n")
    assert main(["login", "--server", SERVER]) == 0
    assert stored_tokens.load_tokens_by_server() == {SERVER: "bon-autre"}
    assert stat.S_IMODE(stored_tokens.path().stat().st_mode) == 0o600


@pytest.mark.parametrize("typed", ["mauvais\n", "\n", "", "jeton…\n"])
def test_one_that_it_does_not_know_is_not_kept(
    tokens_seen: list[str], type_in: Callable[[str], None], capsys: Any, typed: str
) -> None:
    type_in(typed)
    assert main(["login", "--server", SERVER]) == 2
    assert "jeton" in capsys.readouterr().err
    assert not stored_tokens.path().exists()


def test_the_flag_then_the_environment_then_what_was_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    stored_tokens.save_token(SERVER, "gardé")
    monkeypatch.setenv("BALISE_TOKEN", "environnement")
    assert resolve_token("drapeau", SERVER) == "drapeau"
    assert resolve_token(None, SERVER) == "environnement"
    monkeypatch.setenv("BALISE_TOKEN", "")
    stored_tokens.save_token(SERVER, "garde")
    assert resolve_token(None, SERVER) == "garde"


def test_what_was_kept_for_a_server_is_sent_to_no_other() -> None:
    stored_tokens.save_token(SERVER, "garde")
    for other in ("http://balise.example", "https://balise.example:8443", "https://autre.example"):
        with pytest.raises(CommandError, match="il manque un jeton"):
            resolve_token(None, other)


def test_without_a_server_the_last_one_is_meant() -> None:
    with pytest.raises(CommandError, match="à quel serveur"):
        resolve_server(None)
    for server in (SERVER, "https://autre.example", SERVER):
        stored_tokens.save_token(server, "garde")
    assert resolve_server(None) == SERVER
    assert resolve_server("http://ici:8000/") == "http://ici:8000"


def test_a_submission_needs_no_flag_after_a_login(tokens_seen: list[str], tmp_path: Path, capsys: Any) -> None:
    stored_tokens.save_token(SERVER, "mauvais-a-present")
    file = tmp_path / "a.py"
    file.write_text("x = 1")
    assert main(["submit", EXERCISE, str(file)]) == 2
    assert tokens_seen == ["mauvais-a-present"]
    assert "n’est pas valable" in capsys.readouterr().err


@pytest.mark.parametrize("content", ["", "{", "[]", json.dumps({SERVER: 3}), "\xff"])
def test_a_file_that_is_not_ours_is_said_in_a_sentence(content: str) -> None:
    stored_tokens.path().parent.mkdir(parents=True)
    stored_tokens.path().write_bytes(content.encode("latin-1"))
    with pytest.raises(CommandError, match="jetons"):
        stored_tokens.load_tokens_by_server()


def test_the_token_s_variable_is_no_misspelt_setting(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("BALISE_TOKEN", "environnement")
    assert read_settings(workers=1).workers == 1
    assert [name for name, _ in misspelt_variables(["BALISE_TOKEN", "BALISE_TOKENS"])] == ["BALISE_TOKENS"]
