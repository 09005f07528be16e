"""Requests to other machines, the keys read there, our own keys, and the states that are used once."""

from __future__ import annotations

import asyncio
import socket
import threading
from base64 import urlsafe_b64encode
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from datetime import timedelta
from typing import Any
from uuid import UUID, uuid4

import pytest
from sqlalchemy import update
from sqlalchemy.orm import Session

from server.base.errors import Overloaded
from server.database import Database, utc_now
from server.federation import outgoing, pending, providers, repository, signing
from server.federation.errors import FederationRefused, OutgoingError
from server.federation.lti import registration
from server.federation.models import ActivityKind, IdentityProvider, PendingSignIn, Protocol, SigningKey
from server.federation.outgoing import (
    Outgoing,
    OutgoingThreads,
    check_url,
    is_allowed_address,
    origin_of_url,
    parse_networks,
)
from server.federation.remote_keys import RemoteKeyCache, parse_keys
from server.federation.rule_forms import format_claims
from tests.support.coroutines import run_apart
from tests.support.tables import folded

pytest.importorskip("joserfc", reason="the extra `federation` is not installed")

PRIVATE = [
    "127.0.0.1",
    "10.0.0.1",
    "172.16.0.1",
    "192.168.1.1",
    "169.254.169.254",
    "100.64.0.1",
    "0.0.0.0",
    "224.0.0.1",
    "255.255.255.255",
    "::1",
    "fe80::1",
    "fc00::1",
    "fec0::1",
    "::ffff:127.0.0.1",
    "::ffff:10.0.0.1",
    "2002:7f00:1::",
    "64:ff9b::a00:1",
    "ff02::1",
]


@folded("address", PRIVATE)
def test_no_connection_goes_to_a_private_network(address: str) -> None:
    assert not is_allowed_address(address, ())


def test_a_network_of_the_school_is_allowed_where_it_is_named() -> None:
    assert is_allowed_address("93.184.215.14", ())
    assert is_allowed_address("10.1.2.3", parse_networks("10.1.0.0/16"))
    assert not is_allowed_address("10.2.2.3", parse_networks("10.1.0.0/16"))


@folded(
    "url",
    [
        "http://moodle.example/jwks", "ftp://moodle.example", "https://", "//moodle.example", "https://a@moodle.example",
        "https://moodle.example/#x", "https://moodle.example/a b", "https://moodle.example\\@evil.example", "https://é.fr",
        "https://moodle.example:0/", "file:///etc/passwd", "https://moodle.example/" + "a" * 2000, "mailto:a@b",
    ],
)  # fmt: skip
def test_only_whole_https_addresses_are_asked(url: str) -> None:
    with pytest.raises(ValueError):  # noqa: PT011 — of any kind
        check_url(url)


def test_an_origin_has_no_port_that_goes_without_saying() -> None:
    assert (
        origin_of_url("HTTPS://Moodle.example:443/x")
        == origin_of_url("https://moodle.example")
        == "https://moodle.example"
    )
    assert origin_of_url("https://moodle.example:80") != origin_of_url("https://moodle.example")
    assert origin_of_url("https://[::1") == ""


@contextmanager
def listening(*pieces: bytes, pause: float = 0.0) -> Iterator[str]:
    """Yield the address of a server that answers one request with these bytes."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        done = threading.Event()

        def answer() -> None:
            connection, _ = server.accept()
            with connection:
                connection.recv(65536)
                try:
                    for piece in pieces:
                        connection.sendall(piece)
                        if done.wait(pause):
                            return
                except OSError:
                    return

        thread = threading.Thread(target=answer, daemon=True)
        thread.start()
        yield f"http://127.0.0.1:{server.getsockname()[1]}/"
        done.set()
        thread.join()


OPEN = Outgoing(parse_networks("127.0.0.0/8"), insecure=True)
HEAD = b"HTTP/1.1 200 OK\r\nContent-Type: application/json\r\n"


def test_an_answer_is_read_and_its_host_must_be_public() -> None:
    with listening(HEAD + b"Content-Length: 2\r\n\r\n{}") as url:
        with pytest.raises(OutgoingError, match="réseau privé"):
            Outgoing(insecure=True).get_json(url)
        assert OPEN.get_json(url) == {}


@folded(
    ("answer", "why"),
    [
        (b"HTTP/1.1 302 Found\r\nLocation: http://127.0.0.1/\r\nContent-Length: 0\r\n\r\n", "ailleurs"),
        (HEAD + b"Content-Length: 300000\r\n\r\n" + b" " * 300000, "trop longue"),
        (HEAD + b"Content-Length: 2\r\n\r\nno", "JSON"),
        (b"HTTP/1.1 429 Slow\r\nRetry-After: 7\r\nContent-Length: 0\r\n\r\n", "429"),
        (b"garbage", "connexion"),
        (b"", "connexion"),
    ],
)
def test_other_answers_are_refused(answer: bytes, why: str) -> None:
    with listening(answer) as url, pytest.raises(OutgoingError, match=why) as refused:
        OPEN.get_json(url)
    assert refused.value.retry == (why in {"429", "connexion"})
    assert refused.value.retry_after == (7.0 if why == "429" else 0.0)


def test_a_trickle_ends_in_time(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("server.federation.outgoing.TOTAL_SECONDS", 0.2)
    with listening(HEAD, *[b"a"] * 1000, pause=0.01) as url, pytest.raises(OutgoingError, match=r"lente|temps"):
        OPEN.get_json(url)


def rsa(kid: str) -> dict[str, Any]:
    from joserfc.jwk import RSAKey

    return {**RSAKey.generate_key(2048).as_dict(private=False), "kid": kid}


def small_key(kid: str) -> dict[str, Any]:
    """Return a key of 1024 bits."""
    return {
        "kty": "RSA",
        "e": "AQAB",
        "n": urlsafe_b64encode(b"\xc1" + 126 * b"\x55" + b"\x55").decode().strip("="),
        "kid": kid,
    }


def test_only_safe_signing_keys_of_a_list_are_used() -> None:
    good = rsa("a")
    others: list[Any] = [
        {**good, "kid": "b", "use": "enc"}, {**good, "kid": "c", "alg": "none"}, {**good, "kid": "d", "alg": "HS256"},
        {"kty": "oct", "k": "c2VjcmV0", "kid": "e"}, small_key("f"), {**good, "kid": ""}, {**good, "kid": 3}, "g", None,
        {"kty": "EC", "crv": "P-256", "x": "AA", "y": "AA", "kid": "h"}, {"kty": ["RSA"], "kid": "i"},
    ]  # fmt: skip
    assert set(parse_keys({"keys": [good, *others]})) == {"a"}
    for document in ({}, [], {"keys": "a"}, {"keys": [good, good]}, {"keys": [good] * 31}):
        with pytest.raises(OutgoingError):
            parse_keys(document)


class Lists(Outgoing):
    """Answers with this list of keys, or fails."""

    def __init__(self) -> None:
        super().__init__()
        self.keys: list[Any] | None = []
        self.asked = 0

    def get_json(self, url: str, **_options: Any) -> Any:
        self.asked += 1
        if self.keys is None:
            raise OutgoingError("pas de réponse", retry=True)
        return {"keys": self.keys}


def test_a_new_key_is_fetched_seldom_and_an_earlier_list_survives_a_failure() -> None:
    lists, clock = Lists(), [1000.0]
    keys = RemoteKeyCache(lists, lambda: clock[0])
    lists.keys = [rsa("a")]
    assert keys.find("u", "a") is keys.find("u", "a")
    assert lists.asked == 1
    for _ in range(5):
        with pytest.raises(OutgoingError):
            keys.find("u", "unknown")
    assert lists.asked == 1
    clock[0] += 31
    lists.keys = [*lists.keys, rsa("b")]
    assert keys.find("u", "b")
    assert lists.asked == 2
    clock[0] += 601
    lists.keys = None
    assert keys.find("u", "a")
    assert lists.asked == 3


def test_who_comes_while_keys_are_fetched_waits_for_them() -> None:
    """A class that opens an exercise together, after a start of ours, enters together."""
    is_asked, may_answer, lists = threading.Event(), threading.Event(), Lists()
    lists.keys = [rsa("a")]

    class Slow(Lists):
        def get_json(self, url: str, **options: Any) -> Any:
            is_asked.set()
            assert may_answer.wait(300)
            return lists.get_json(url, **options)

    keys = RemoteKeyCache(Slow())
    with ThreadPoolExecutor(8) as threads:
        first = threads.submit(keys.find, "u", "a")
        assert is_asked.wait(300)
        others = [threads.submit(keys.find, "u", "a") for _ in range(7)]
        may_answer.set()
        assert {id(key.result()) for key in (first, *others)} == {id(first.result())}
    assert lists.asked == 1
    lists.keys = None
    with pytest.raises(OutgoingError, match="pas de réponse"):
        keys.find("v", "a")


def test_a_server_that_hangs_holds_up_its_own_people_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    threads, may_answer, hung = OutgoingThreads(), threading.Event(), threading.Semaphore(0)
    dead = range(outgoing.THREADS // outgoing.SHARE - 1)

    def hang() -> str:
        hung.release()
        assert may_answer.wait(300)
        return "late"

    async def visit() -> None:
        held = [asyncio.ensure_future(threads.run(school, hang)) for school in dead for _ in range(outgoing.SHARE + 1)]
        for _ in range(len(dead) * outgoing.SHARE):
            assert await asyncio.to_thread(hung.acquire, timeout=300)
        assert not hung.acquire(blocking=False), "a school has more than its share"
        assert await threads.run("alive", lambda: "at once") == "at once"
        gone = held.pop(0)
        gone.cancel()
        with pytest.raises(asyncio.CancelledError):
            await gone
        monkeypatch.setattr(outgoing, "WAIT_SECONDS", 0)
        with pytest.raises(Overloaded):  # the thread of a browser that has gone is busy still
            await threads.run(0, lambda: "at once")
        monkeypatch.setattr(outgoing, "MAX_CALLS", 1)
        with pytest.raises(Overloaded):
            await threads.run(1, lambda: "at once")
        may_answer.set()
        assert set(await asyncio.gather(*held)) == {"late"}
        monkeypatch.undo()
        assert await threads.run(0, lambda: "at once") == "at once"

    run_apart(visit())


def test_what_no_database_stores_is_refused_or_made_readable(database: Database) -> None:
    """PostgreSQL refuses U+0000 in a text, and UTF-8 half a surrogate pair: whoever sends one gets an answer."""
    provider_id, _, _ = begun(database)
    with database.write() as db:
        repository.record_activity(db, provider_id, ActivityKind.sign_in, utc_now(), "a\0\ud800", succeeded=False)
        (activity,) = repository.load_activity(db, [provider_id])
        assert activity.detail == "a??"
        for issuer, client in (("https://moodle.example/\0", ""), ("https://moodle.example", "\0")):
            with pytest.raises(FederationRefused):
                registration.find_platform(db, issuer, client)
    assert format_claims({"name": "\ud800"}) == '{\n  "name": "?"\n}'


def test_our_keys_are_published_before_they_sign_and_go_in_time(sqlite: Database) -> None:
    now = utc_now()
    (first,) = signing.load_keys(sqlite, now)
    assert signing.choose_signing_key([first], now).id == first.id
    old = now - signing.LIFETIME - timedelta(days=1)
    with sqlite.write() as db:
        db.merge(SigningKey(id=first.id, private_pem=first.private_pem, created_at=old))
    second, kept = signing.load_keys(sqlite, now)
    assert (kept.id, signing.choose_signing_key([second, kept], now).id) == (first.id, first.id)
    assert signing.choose_signing_key([second, kept], now + signing.LEAD_TIME).id == second.id
    assert {key["kid"] for key in signing.published_keys(sqlite)["keys"]} == {str(first.id), str(second.id)}
    assert not any({"d", "p", "q"} & key.keys() for key in signing.published_keys(sqlite)["keys"])
    later = now + 3 * signing.LIFETIME
    assert first.id not in {key.id for key in signing.load_keys(sqlite, later)}


def test_many_requests_at_once_make_one_key(database: Database) -> None:
    with ThreadPoolExecutor(4) as threads:
        found = list(threads.map(lambda _: signing.load_keys(database, utc_now())[0].id, range(4)))
    assert len(set(found)) == 1


def begun(database: Database) -> tuple[UUID, pending.BegunSignIn, str]:
    with database.write() as db:
        provider = IdentityProvider(
            protocol=Protocol.lti, name="Moodle", issuer="https://moodle.example", client_id=uuid4().hex, settings={}
        )
        db.add(provider)
        db.flush()
        state = pending.begin_sign_in(db, provider.id, "/", {})
        nonce = pending.replace_nonce(db, pending.find_pending_sign_in(db, state.state), {})
    return provider.id, state, nonce


def test_a_state_serves_once_however_many_come_at_once(database: Database) -> None:
    _, state, nonce = begun(database)

    def use(_: int) -> bool:
        try:
            with database.write() as db:
                pending.consume_sign_in(db, pending.find_pending_sign_in(db, state.state), nonce)
        except FederationRefused:
            return False
        return True

    with ThreadPoolExecutor(8) as threads:
        assert sum(threads.map(use, range(64))) == 1


@folded("case", ["other nonce", "no nonce", "other browser", "too late", "other state", "removed meanwhile"])
def test_a_state_serves_its_own_browser_in_time(case: str, sqlite: Database) -> None:
    provider, state, nonce = begun(sqlite)
    with sqlite.write() as db:
        if case == "too late":
            db.execute(update(PendingSignIn).values(expires_at=utc_now() - timedelta(seconds=1)))
        if case == "removed meanwhile":
            providers.remove_provider(db, providers.find_provider(db, provider), None)
    with sqlite.write() as db, pytest.raises(FederationRefused):
        use_up(db, state, nonce, case)


def use_up(db: Session, state: pending.BegunSignIn, nonce: str, case: str) -> None:
    row = pending.find_pending_sign_in(db, "x" if case == "other state" else state.state)
    pending.require_browser(row, "other" if case == "other browser" else state.browser)
    pending.consume_sign_in(db, row, {"other nonce": "x", "no nonce": None}.get(case, nonce))
