"""Refusals of this room: what another system sent, or answered, is not accepted."""

from server.base.errors import Forbidden


class FederationRefused(Forbidden):
    """A sign-in, a registration or a launch that is not accepted. `code` names the reason in the activity."""

    slug = "connexion-refusee"
    title = "Connexion refusée"

    def __init__(self, code: str, detail: str) -> None:
        super().__init__(detail)
        self.code = code


class OutgoingError(Exception):
    """Another machine did not answer as it should. `retry`: a later try may succeed; `status` is its HTTP status.

    `retry_after` is in seconds, 0 where it said nothing.
    """

    def __init__(self, reason: str, *, status: int = 0, retry: bool = False, retry_after: float = 0.0) -> None:
        super().__init__(reason)
        self.reason, self.status, self.retry, self.retry_after = reason, status, retry, retry_after
