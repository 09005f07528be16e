"""What is named by a UUID in an address or a request."""

from uuid import UUID

from server.base.errors import NotFound


def identity_of(text: UUID | str, unknown: str) -> UUID:
    """The UUID that a text is; a text that is none names nothing: raises NotFound, with the sentence `unknown`."""
    try:
        return text if isinstance(text, UUID) else UUID(text)
    except ValueError as error:
        raise NotFound(unknown) from error
