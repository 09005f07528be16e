"""Whom the limits count as one visitor, in front of a proxy and behind one."""

from __future__ import annotations

from ipaddress import ip_network

import pytest
from fastapi import FastAPI, Request

from server.base.http import client_address, visitor_key
from server.base.http_protocol import sender_key
from server.base.settings import Settings
from server.cli import CommandError
from server.cli.configuration import read_settings
from server.cli.serve import build_uvicorn_config
from tests.support.client import TestClient

PROXY, VISITOR, FORGED = "10.0.0.1", "203.0.113.7", "198.51.100.99"


@pytest.mark.parametrize(
    ("host", "visitor"),
    [
        ("203.0.113.7", "203.0.113.7"),
        ("::ffff:203.0.113.7", "203.0.113.7"),
        ("2001:db8:1:2:3:4:5:6", "2001:db8:1:2::/64"),
        ("2001:db8:1:2:ffff::1", "2001:db8:1:2::/64"),
        ("2001:db8:1:3::1", "2001:db8:1:3::/64"),
        ("fe80::1%eth0", "fe80::/64"),
        ("::1", "::/64"),
        ("testclient", "inconnue"),
        ("x" * 5000, "inconnue"),
    ],
)
def test_an_ipv6_subscriber_is_one_visitor(host: str, visitor: str) -> None:
    assert visitor_key(host) == visitor


def seen(peer: str, headers: list[tuple[str, str]], trusted: str = "") -> tuple[str, str]:
    """The address and the scheme that the application sees, of a request from `peer`, as `balise serve` has it."""
    app = FastAPI()

    @app.get("/")
    def tell(request: Request) -> tuple[str, str]:
        return client_address(request), request.url.scheme

    config = build_uvicorn_config(app, Settings(trusted_proxy=trusted))
    config.load()
    client = TestClient(config.loaded_app, client=(peer, 1))  # type: ignore[arg-type]
    address, scheme = client.get("/", headers=headers).json()
    head = "GET / HTTP/1.1\r\nhost: a\r\n" + "".join(f"{name}: {value}\r\n" for name, value in headers) + "\r\n"
    proxies = [ip_network(proxy) for proxy in Settings(trusted_proxy=trusted).trusted_proxies]
    assert sender_key(peer, head.encode(), proxies) == address, "the line in front of the application knows the same"
    return address, scheme


FORGERY = [("X-Forwarded-For", FORGED), ("X-Forwarded-Proto", "https")]


@pytest.mark.parametrize("peer", ["127.0.0.1", VISITOR])
def test_nobody_is_believed_by_default(peer: str) -> None:
    assert seen(peer, FORGERY) == (peer, "http")


def test_the_environment_of_another_program_opens_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("FORWARDED_ALLOW_IPS", "*")
    assert seen(VISITOR, FORGERY) == (VISITOR, "http")


def test_a_trusted_proxy_is_believed_and_nobody_else() -> None:
    told = [("X-Forwarded-For", VISITOR), ("X-Forwarded-Proto", "https")]
    assert seen(PROXY, told, trusted=f"{PROXY}, ::1") == (VISITOR, "https")
    assert seen("127.0.0.1", told, trusted=PROXY) == ("127.0.0.1", "http")
    assert seen(PROXY, told, trusted="10.0.0.0/24") == (VISITOR, "https")


def test_what_a_visitor_forges_in_front_of_the_proxy_does_nothing() -> None:
    appended = [("X-Forwarded-For", f"{FORGED}, {VISITOR}")]
    assert seen(PROXY, appended, trusted=PROXY)[0] == VISITOR
    twice = [("X-Forwarded-For", FORGED), ("X-Forwarded-For", VISITOR)]
    assert seen(PROXY, twice, trusted=PROXY)[0] == VISITOR
    behind_two = [("X-Forwarded-For", f"{FORGED}, {VISITOR}, 10.0.0.2")]
    assert seen(PROXY, behind_two, trusted="10.0.0.1,10.0.0.2")[0] == VISITOR


@pytest.mark.parametrize("text", ["localhost", "*", "10.0.0.1/8", "10.0.0.1;10.0.0.2", "10.0.0.300"])
def test_what_is_no_address_is_refused_at_once_in_french(text: str) -> None:
    with pytest.raises(CommandError, match="n’est ni une adresse IP ni un réseau"):
        read_settings(trusted_proxy=text)
