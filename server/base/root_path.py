"""Where on its site the service stands: at the root, or under the path that a reverse proxy gives it.

Inside, every address begins at the service's own root (`/classes`), as if there were no such path. It is taken off the
requests as they come in, and put before the addresses as they go out: of pages by `written`, of JSON by `address`,
of redirections by `Mounted`. One process serves one site: the path is what the application was last built with.
"""

from __future__ import annotations

import re

from starlette.datastructures import Headers, MutableHeaders
from starlette.requests import HTTPConnection
from starlette.types import ASGIApp, Message, Receive, Scope, Send

#: The attributes of our pages that hold an address.
ATTRIBUTES = (
    "href", "src", "srcset", "action", "formaction",
    "data-source", "data-action", "data-hands", "data-answers", "data-save", "data-stream", "data-progress",
    "data-events", "data-verdict", "data-steps",
)  # fmt: skip
#: Our templates and our Markdown write every address so, and escape quotes in what they show.
_ADDRESS = re.compile(rf'(?<=\s)({"|".join(ATTRIBUTES)})="/(?!/)')

_roots = [""]


def set_root_path(root: str) -> None:
    """From now on this process serves under this path: `/balise`, or nothing."""
    _roots[0] = root


def root_path() -> str:
    return _roots[0]


def external_path(path: str) -> str:
    """An address of the service, as the outside knows it."""
    return f"{root_path()}{path}"


def with_external_paths(page: str) -> str:
    """The HTML of a page, or of a part of one, as the outside knows its addresses."""
    return _ADDRESS.sub(rf'\1="{root_path()}/', page) if root_path() else page


def service_url(connection: HTTPConnection) -> str:
    """The service's whole address as this visitor has it, without a slash at its end."""
    return f"{connection.url.scheme}://{connection.url.netloc}{root_path()}"


class RootPathMiddleware:
    """Takes the path off what is asked, whether or not the proxy has left it there; puts it before redirections."""

    def __init__(self, app: ASGIApp, root: str) -> None:
        self._app, self._root = app, root

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            return await self._app(scope, receive, send)

        # Starlette sends on whoever writes a slash too many, with the whole address.
        here = f"{scope['scheme']}://{Headers(scope=scope).get('host', '')}"

        async def send_outwards(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = MutableHeaders(scope=message)
                place = headers.get("location", "").removeprefix(here)
                if place.startswith("/") and not place.startswith("//"):
                    headers["location"] = f"{self._root}{place}"
            await send(message)

        scope.update(self._inside(scope))  # whatever answers for an application that failed reads it as well
        await self._app(scope, receive, send_outwards)

    def _inside(self, scope: Scope) -> dict[str, object]:
        raw = scope.get("raw_path") or b""
        return {
            "path": self._stripped(scope["path"]),
            "raw_path": self._stripped(raw.decode("latin-1")).encode("latin-1"),
        }

    def _stripped(self, path: str) -> str:
        if path == self._root:
            return "/"
        return path.removeprefix(self._root) if path.startswith(f"{self._root}/") else path
