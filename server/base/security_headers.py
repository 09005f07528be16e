"""Security headers of every answer; the pages of a session of a frame may be shown by its platform, and by no other."""

from starlette.types import ASGIApp, Message, Receive, Scope, Send

DIRECTIVES = {
    "default-src": "'self'",
    "script-src": "'self'",
    "style-src": "'self'",
    "style-src-attr": "'unsafe-inline'",  # KaTeX places its glyphs with style attributes
    "img-src": "'self' data:",
    "object-src": "'none'",
    "base-uri": "'none'",
    "form-action": "'self'",
    "frame-ancestors": "'none'",
}


def content_security_policy(frames: str = "", form_action: str = "") -> str:
    """Return the policy of a page.

    `frames` are origins, separated by spaces, whose pages may show it; `form_action` is one more to which it may post.
    """
    directives = dict(DIRECTIVES)
    if frames:
        directives["frame-ancestors"] = frames
    if form_action:
        directives["form-action"] += f" {form_action}"
    return "; ".join(f"{name} {value}" for name, value in directives.items())


CONTENT_SECURITY_POLICY = content_security_policy()
SECURITY_HEADERS = {
    "Content-Security-Policy": CONTENT_SECURITY_POLICY,
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "same-origin",
    "Cross-Origin-Opener-Policy": "same-origin",
}
#: Of the state of a request: the origins whose pages may show the answer in a frame, separated by spaces.
FRAMES_STATE = "frame_origins"
_SECURITY = [(name.lower().encode(), value.encode()) for name, value in SECURITY_HEADERS.items()]
_POLICY = b"content-security-policy"


class SecurityHeadersMiddleware:
    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            return await self._app(scope, receive, send)
        state = scope.setdefault("state", {})

        async def send_with_headers(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = list(message["headers"])
                given = {name for name, _ in headers}
                if _POLICY not in given and state.get(FRAMES_STATE):
                    given.add(_POLICY)
                    headers.append((_POLICY, content_security_policy(state[FRAMES_STATE]).encode()))
                message["headers"] = [*headers, *(header for header in _SECURITY if header[0] not in given)]
            await send(message)

        await self._app(scope, receive, send_with_headers)
