"""What every answer goes through: a name for the logs, encodings that were refused, bounded bodies, refusal of
cross-site requests, session cookie, security headers.

Plain ASGI, so that streams (server-sent events) pass through untouched.
"""

import asyncio
import time
from collections.abc import Awaitable, Callable

from starlette.concurrency import run_in_threadpool
from starlette.datastructures import Headers, MutableHeaders
from starlette.requests import ClientDisconnect, Request
from starlette.responses import Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from server.base import logs, traces
from server.base.arrival import record_arrival
from server.base.counters import VISITS
from server.base.errors import Forbidden, Invalid, LengthRequired, ServiceError, TooLarge
from server.base.forms import decode_large_form
from server.base.http import (
    API,
    DEVICE_COOKIE,
    FRAMED_COOKIE,
    LAUNCH_PATHS,
    MONITORING_PATHS,
    SAFE_METHODS,
    SESSION_COOKIE,
    accepted_encodings,
    error_document,
    problem_response,
    split_address,
)
from server.base.validation import format_size

UNKNOWN_LENGTH = (
    "Cette demande n’annonce pas sa longueur : envoyez l’en-tête « Content-Length » plutôt que des morceaux "
    "(« Transfer-Encoding: chunked »)."
)
CUT_OFF = "Cette demande s’est interrompue avant sa fin : rien n’en a été pris en compte."
#: Where a scope holds the error by which a middleware refuses its request, for `RefusalMiddleware`.
REFUSAL = "balise.refusal"
REQUEST_ID = "X-Request-ID"
Refuse = Callable[[Request, ServiceError], Response]


class RequestLogMiddleware:
    """Gives each request a name, which goes with what it has done later, and tells in the logs what came of it.

    A trusted proxy may have named it already. Its route is told, and not its address: addresses hold one-time links.
    """

    def __init__(self, app: ASGIApp, proxied: bool) -> None:
        self._app, self._proxied = app, proxied

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            return await self._app(scope, receive, send)
        given = Headers(scope=scope).get(REQUEST_ID, "") if self._proxied else ""
        name = given if logs.REQUEST_ID_PATTERN.fullmatch(given) else logs.new_request_id()
        began, status = time.perf_counter(), 500

        async def send_with_name(message: Message) -> None:
            nonlocal status
            if message["type"] == "http.response.start":
                status = message["status"]
                MutableHeaders(scope=message)[REQUEST_ID] = name
            await send(message)

        parent = Headers(scope=scope).get(traces.TRACE, "") if self._proxied else ""
        with logs.request_context(name), traces.request_span(scope["method"], parent) as span:
            try:
                await self._app(scope, receive, send_with_name)
            finally:
                if scope["path"] not in MONITORING_PATHS:
                    VISITS.record(_visitor_bytes(scope))
                route = route_path(scope)
                seconds = round(time.perf_counter() - began, 4)
                traces.record_response(span, scope["method"], route, status)
                logs.log_event("request", method=scope["method"], route=route, status=status, seconds=seconds)


def route_path(scope: Scope) -> str:
    """The path of the route that answered; of a router's, with what it was included under, where FastAPI tells it."""
    included = scope.get("fastapi", {}).get("effective_route_context")
    return str(getattr(included, "path", "") or getattr(scope.get("route"), "path", ""))


def _visitor_bytes(scope: Scope) -> bytes:
    """What tells one from another: the session or the token that they show, else where they come from."""
    for name, value in scope["headers"]:
        if name in {b"cookie", b"authorization"}:
            return bytes(value)
    return str((scope.get("client") or ("",))[0]).encode()


class RefusedEncodingsMiddleware:
    """Removes refused encodings (`gzip;q=0`) from `Accept-Encoding`: compressors look for a name alone there."""

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "http" and any(map(_has_quality_values, scope["headers"])):
            scope["headers"] = [(name, _remove_refused_encodings(name, value)) for name, value in scope["headers"]]
        await self._app(scope, receive, send)


def _has_quality_values(header: tuple[bytes, bytes]) -> bool:
    return header[0] == b"accept-encoding" and b";" in header[1]


def _remove_refused_encodings(name: bytes, value: bytes) -> bytes:
    weighed = _has_quality_values((name, value))
    return ", ".join(accepted_encodings(value.decode("latin-1"))).encode("latin-1") if weighed else value


class HeadAsGetMiddleware:
    """Answers HEAD as GET, without the body (RFC 9110, 9.3.2).

    What the answer says of its length stays. A stream is told that its reader has left.
    """

    def __init__(self, app: ASGIApp) -> None:
        self.app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http" or scope["method"] != "HEAD":
            await self.app(scope, receive, send)
            return
        started = asyncio.Event()

        async def send_head(message: Message) -> None:
            if message["type"] == "http.response.start":
                await send(message)
                started.set()

        async def receive_until_started() -> Message:
            if started.is_set():
                return {"type": "http.disconnect"}
            return await receive()

        await self.app({**scope, "method": "GET"}, receive_until_started, send_head)
        if started.is_set():
            await send({"type": "http.response.body", "body": b""})


class SessionCookieMiddleware:
    """Sets the cookies that a dependency asked for: of the session, and of a browser that is known from then on.

    `max_age` and `device_max_age` are in seconds. An empty token deletes its cookie. The session of a frame has a
    cookie of its own (CHIPS: partitioned by the site that shows the frame); to open one session ends the other.
    """

    def __init__(self, app: ASGIApp, max_age: int, device_max_age: int, path: str) -> None:
        self._app, self._path = app, path
        #: The session's comes last: of several in one header, many a client reads the attributes of the last alone.
        self._cookies = (
            ("device_token", DEVICE_COOKIE, device_max_age),
            ("framed_token", FRAMED_COOKIE, max_age),
            ("session_token", SESSION_COOKIE, max_age),
        )

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            return await self._app(scope, receive, send)
        state = scope.setdefault("state", {})

        async def send_with_cookie(message: Message) -> None:
            if message["type"] == "http.response.start":
                for key, name, max_age in self._cookies:
                    token = state.get(key)
                    if token is not None:
                        cookie = self._cookie_header_value(name, token, max_age, scope["scheme"] == "https")
                        MutableHeaders(scope=message).append("Set-Cookie", cookie)
            await send(message)

        await self._app(scope, receive, send_with_cookie)

    def _cookie_header_value(self, name: str, token: str, max_age: int, secure: bool) -> str:
        age = max_age if token else 0
        cookie, lax = f"{name}={token}; Max-Age={age}; Path={self._path}; HttpOnly", "; SameSite=Lax"
        if name == FRAMED_COOKIE:
            return f"{cookie}; Secure; SameSite=None; Partitioned"
        if not secure:
            return cookie + lax
        return f"{cookie}{lax}; Secure" if name == SESSION_COOKIE else f"{cookie}; Secure{lax}"


class SameOriginMiddleware:
    """Refuses unsafe requests that another site has a browser send with our cookie.

    Browsers say where a request comes from (Sec-Fetch-Site, else Origin); a request that says neither is no browser's.
    The API knows no cookie, so it needs no such check.
    """

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "http" and _is_forged(scope):
            scope[REFUSAL] = Forbidden("Cette demande vient d’un autre site : elle a été refusée.")
        await self._app(scope, receive, send)


def _is_forged(scope: Scope) -> bool:
    if scope["method"] in SAFE_METHODS or scope["path"].startswith(API) or scope["path"] in LAUNCH_PATHS:
        return False
    headers = Headers(scope=scope)
    site = headers.get("sec-fetch-site")
    if site is not None:
        return site not in {"same-origin", "none"}
    origin = headers.get("origin")
    return origin is not None and split_address(origin).netloc != headers.get("host")


class BodyLimitMiddleware:
    """Refuses a body of more than `most` bytes before anything reads it whole, and one whose length is not announced.

    A body in chunks may have pieces of one byte: each is parsed in Python on the loop that serves everybody. The
    connection is closed by the refusal. Browsers, curl and proxies that buffer announce lengths.
    """

    def __init__(self, app: ASGIApp, most: int) -> None:
        self._app, self._most = app, most

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http" or REFUSAL in scope:
            return await self._app(scope, receive, send)
        try:
            if any(name == b"transfer-encoding" for name, _ in scope["headers"]):
                raise LengthRequired(UNKNOWN_LENGTH)
            if scope["method"] not in SAFE_METHODS:
                body = await self._read(scope, receive)
                record_arrival()
                receive = _replay_body(body, receive)
        except ClientDisconnect:
            nobody_reads = problem_response(error_document(Request(scope), Invalid(CUT_OFF)))
            return await nobody_reads(scope, receive, send)
        except ServiceError as error:
            scope[REFUSAL] = error
        await self._app(scope, receive, send)

    async def _read(self, scope: Scope, receive: Receive) -> bytes:
        """Return the body.

        Raises TooLarge, at once where its length is announced; ClientDisconnect for half a request.
        """
        announced = next((value for name, value in scope["headers"] if name == b"content-length"), b"")
        if announced.isdigit() and int(announced) > self._most:
            raise self._too_large()
        chunks, size, more = list[bytes](), 0, True
        while more:
            message = await receive()
            if message["type"] == "http.disconnect":
                raise ClientDisconnect
            chunk = message.get("body", b"")
            size += len(chunk)
            if size > self._most:
                raise self._too_large()
            chunks.append(chunk)
            more = message.get("more_body", False)
        return b"".join(chunks)

    def _too_large(self) -> TooLarge:
        return TooLarge(f"Cette demande dépasse {format_size(self._most)}.")


class LargeFormMiddleware:
    """Decodes large forms, whose bodies are whole, in their turn."""

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "http" and scope["method"] not in SAFE_METHODS and REFUSAL not in scope:
            body = (await receive()).get("body", b"")
            try:
                scope, body = decode_large_form(scope, body)
            except ServiceError as error:
                scope[REFUSAL] = error
            receive = _replay_body(body, receive)
        await self._app(scope, receive, send)


class RefusalMiddleware:
    """Answers what was refused before it had a turn: the page that says so takes as long to make as any other."""

    def __init__(self, app: ASGIApp, refuse: Refuse) -> None:
        self._app, self._refuse = app, refuse

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        app = self._app
        if REFUSAL in scope:
            app = await run_in_threadpool(self._refuse, Request(scope), scope[REFUSAL])
        await app(scope, receive, send)


def _replay_body(body: bytes, receive: Receive) -> Callable[[], Awaitable[Message]]:
    given = False

    async def resend() -> Message:
        nonlocal given
        if given:
            return await receive()
        given = True
        return {"type": "http.request", "body": body, "more_body": False}

    return resend
