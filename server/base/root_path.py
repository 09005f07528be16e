"""The path under which a reverse proxy serves the application.

Inside, every path begins at the application's root (`/classes`). The root path is stripped from requests, and prefixed
to outgoing addresses: in pages by `with_external_paths`, in JSON by `external_path`, in redirections by
`RootPathMiddleware`. One process serves one site: the path of the application that was built last.
"""

from __future__ import annotations

import re

from starlette.datastructures import Headers, MutableHeaders
from starlette.requests import HTTPConnection
from starlette.types import ASGIApp, Message, Receive, Scope, Send

#: Attributes of the pages' HTML that hold an address.
ATTRIBUTES = (
    "href", "src", "srcset", "action", "formaction",
    "data-source", "data-action", "data-hands", "data-answers", "data-save", "data-stream", "data-progress",
    "data-events", "data-verdict", "data-steps", "data-check", "data-close", "data-later", "data-presence",
    "data-preview", "data-trial",
)  # fmt: skip
#: Templates and Markdown write every address in this form, and escape quotes in text.
_ADDRESS = re.compile(rf'(?<=\s)({"|".join(ATTRIBUTES)})="/(?!/)')

_roots = [""]


def set_root_path(root: str) -> None:
    """Serve under this path from now on: `/balise`, or an empty string."""
    _roots[0] = root


def root_path() -> str:
    return _roots[0]


def external_path(path: str) -> str:
    """Prefix the root path to a path of the application."""
    return f"{root_path()}{path}"


def with_external_paths(page: str) -> str:
    """Prefix the root path to every address in the HTML of a page or fragment."""
    return _ADDRESS.sub(rf'\1="{root_path()}/', page) if root_path() else page


def service_url(connection: HTTPConnection) -> str:
    """Return the application's URL as this visitor has it, without a trailing slash."""
    return f"{connection.url.scheme}://{connection.url.netloc}{root_path()}"


class RootPathMiddleware:
    """Strips the root path from requests, whether or not the proxy left it there; prefixes it to redirections."""

    def __init__(self, app: ASGIApp, root: str) -> None:
        self._app, self._root = app, root

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            return await self._app(scope, receive, send)

        # Starlette redirects a trailing slash to an absolute URL.
        here = f"{scope['scheme']}://{Headers(scope=scope).get('host', '')}"

        async def send_outwards(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = MutableHeaders(scope=message)
                location = headers.get("location", "").removeprefix(here)
                if location.startswith("/") and not location.startswith("//"):
                    headers["location"] = f"{self._root}{location}"
            await send(message)

        scope.update(self._scope_inside_root_path(scope))  # in place: the handler of unexpected errors reads it too
        await self._app(scope, receive, send_outwards)

    def _scope_inside_root_path(self, scope: Scope) -> dict[str, object]:
        raw = scope.get("raw_path") or b""
        return {
            "path": self._strip_root_path(scope["path"]),
            "raw_path": self._strip_root_path(raw.decode("latin-1")).encode("latin-1"),
        }

    def _strip_root_path(self, path: str) -> str:
        if path == self._root:
            return "/"
        return path.removeprefix(self._root) if path.startswith(f"{self._root}/") else path
