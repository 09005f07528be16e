"""The middleware of the application, from the innermost to the outermost."""

from fastapi import FastAPI
from starlette.middleware.gzip import GZipMiddleware

from server.base import middleware, root_path, turns
from server.base.security_headers import SecurityHeadersMiddleware
from server.base.settings import Settings
from server.identity.devices import DEVICE_DAYS
from server.web import errors

DAY = 86400
GZIP_LEVEL = 4  # mathematics in HTML shrink twelvefold; higher levels gain little and cost time


def add_middleware_stack(app: FastAPI, settings: Settings) -> None:
    """Add every middleware, with the limits and cookie lifetimes of the settings."""
    app.add_middleware(middleware.RefusalMiddleware, refuse=errors.render_service_error)
    app.add_middleware(middleware.LargeFormMiddleware)
    app.add_middleware(turns.FairTurnsMiddleware, refuse=errors.render_service_error)
    app.add_middleware(middleware.BodyLimitMiddleware, most=settings.body_bytes)
    app.add_middleware(middleware.SameOriginMiddleware)
    app.add_middleware(
        middleware.SessionCookieMiddleware,
        max_age=settings.session_days * DAY,
        device_max_age=DEVICE_DAYS * DAY,
        path=settings.root_path or "/",
    )
    app.add_middleware(SecurityHeadersMiddleware)
    app.add_middleware(GZipMiddleware, minimum_size=1024, compresslevel=GZIP_LEVEL)
    app.add_middleware(middleware.RefusedEncodingsMiddleware)
    app.add_middleware(middleware.HeadAsGetMiddleware)
    app.add_middleware(middleware.RequestLogMiddleware, proxied=bool(settings.trusted_proxies))
    if settings.root_path:
        app.add_middleware(root_path.RootPathMiddleware, root=settings.root_path)
