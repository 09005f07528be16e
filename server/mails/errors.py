"""A mail that was not sent, with the reason as teachers and administrators read it."""


class MailError(Exception):
    """`retry`: the next try may succeed; `is_address`: the recipient's address is at fault."""

    def __init__(self, reason: str, *, retry: bool, is_address: bool = False) -> None:
        super().__init__(reason)
        self.reason, self.retry, self.is_address = reason, retry, is_address


class LostAnswerError(MailError):
    """The message was handed over, and the server's answer never came: it may have been sent."""
