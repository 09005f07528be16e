"""A text that somebody sends, as bytes of a bounded length."""

from server.base.errors import Invalid, TooLarge
from server.base.sizes import size


def encoded(text: str, most: int, what: str = "Le code") -> bytes:
    """The text in UTF-8. Raises Invalid for what is no text, TooLarge above `most` bytes.

    `what` is the subject of the sentence, in the singular.
    """
    try:
        source = text.encode()
    except UnicodeEncodeError as error:
        raise Invalid(f"{what} contient un caractère qui n’existe pas en Unicode.") from error
    if len(source) > most:
        raise TooLarge(f"{what} dépasse de {size(len(source) - most)} la limite de {size(most)}.")
    return source
