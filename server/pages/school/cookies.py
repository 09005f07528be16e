"""The cookie of a browser that begins a sign-in: it goes with the cross-site form of a platform, in a frame too."""

from __future__ import annotations

from fastapi import Request, Response

from server.base.http import cookie_value
from server.base.root_path import root_path
from server.federation import pending

ATTRIBUTES = "HttpOnly; Secure; SameSite=None; Partitioned"


def set_state_cookie(response: Response, begun: pending.BegunSignIn) -> None:
    seconds = int(pending.LIFETIME.total_seconds())
    _append_set_cookie(response, pending.cookie_name(begun.state), begun.browser, seconds)


def clear_state_cookie(response: Response, state: str) -> None:
    _append_set_cookie(response, pending.cookie_name(state), "", 0)


def _append_set_cookie(response: Response, name: str, value: str, seconds: int) -> None:
    cookie = f"{name}={value}; Max-Age={seconds}; Path={root_path() or '/'}; {ATTRIBUTES}"
    response.headers.append("Set-Cookie", cookie)


def read_state_cookie(request: Request, state: str) -> str:
    """Return what the browser has kept of a sign-in that it began; empty for another browser."""
    return cookie_value(request, pending.cookie_name(state))
