"""Errors that the user can do something about."""


class ClientError(Exception):
    """A request or a command that cannot be carried out; its message is French and for the user."""


class ServerUnavailableError(ClientError):
    """The server does not answer, or asks to come back later."""
