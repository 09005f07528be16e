"""A text that somebody sends, as bytes of a bounded length."""

from server.base.errors import Invalid, TooLarge


def encoded(text: str, most: int, what: str = "Le code") -> bytes:
    """The text in UTF-8. Raises Invalid for what is no text, TooLarge above `most` bytes.

    `what` is the subject of the sentence, in the singular.
    """
    try:
        source = text.encode()
    except UnicodeEncodeError as error:
        raise Invalid(f"{what} contient un caractère qui n’existe pas en Unicode.") from error
    if len(source) > most:
        raise TooLarge(f"{what} fait {len(source)} octets ; la limite est de {most} octets.")
    return source
