"""HTTP as this service reads it, for all that serves the application."""

from __future__ import annotations

from collections.abc import Sequence

import uvicorn
from starlette.types import ASGIApp

#: Bytes of a request without its body; and of what comes without anything of a body, or a request, being ended by it.
HEAD = 64 * 1024


def configuration(app: ASGIApp, *, grace: int, proxies: Sequence[str] = ()) -> uvicorn.Config:
    """How the application is served. `grace`: seconds left to open connections when it stops; `proxies`: whose word is
    taken for where a request comes from.

    Parser and loop are said, whatever is installed. That of httptools passes the body of a request that asks for an
    upgrade on as the next request, and bounds nothing; the loop of uvloop starts no process in a group of its own, and
    leaves those that it starts descriptors which are not theirs.
    """
    return uvicorn.Config(
        app,
        loop="asyncio",
        http="h11",
        h11_max_incomplete_event_size=HEAD,
        ws="none",
        log_config=None,
        access_log=False,
        timeout_graceful_shutdown=grace,
        server_header=False,
        proxy_headers=bool(proxies),
        forwarded_allow_ips=list(proxies),
    )
