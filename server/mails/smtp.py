"""Hand one message to the administrator's SMTP server. Calls block: they are made in a thread that serves nobody."""

from __future__ import annotations

import re
import smtplib
import ssl
from collections.abc import Callable
from contextlib import suppress
from email.message import EmailMessage
from email.policy import SMTP

from server.base.settings import Settings
from server.mails.errors import LostAnswerError, MailError

SECONDS = 15.0  # for each answer of the server
REPLY_LENGTH = 120
UNPRINTABLE = re.compile(r"[^ -~]+")
#: Servers repeat the address, which no log is to hold.
ANY_ADDRESS = re.compile(r"<?[^\s<>@]+@[^\s<>@]+>?")
NO_TLS = "le serveur n’offre pas STARTTLS : donnez BALISE_SMTP_TLS=tls (port 465), ou un autre port"
NO_PASSWORD_IN_CLEAR = "un mot de passe ne part jamais sans TLS : réglez BALISE_SMTP_TLS, ou retirez BALISE_SMTP_USER"


def is_smtp_configured(settings: Settings) -> bool:
    """Whether an administrator has set a server that takes mails."""
    return bool(settings.smtp_host)


def sender_address(settings: Settings) -> str:
    """Return the address that mails come from: the one that is set, else the user's, else one of the server."""
    if settings.smtp_from:
        return settings.smtp_from
    return settings.smtp_user if "@" in settings.smtp_user else f"balise@{settings.smtp_host}"


def send_message(settings: Settings, message: EmailMessage, on_handover: Callable[[], None] = lambda: None) -> None:
    """Send a message to the one address of its `To`. Raises MailError.

    `on_handover` is called once the recipient is accepted, just before the message itself leaves.
    """
    try:
        server = _connect(settings)
        try:
            _require_accepted(server.mail(sender_address(settings)), "l’expéditeur", is_address=False)
            _require_accepted(server.rcpt(str(message["To"])), "l’adresse", is_address=True)
            on_handover()
            _send_data(server, message)
        finally:
            _quit_session(server)
    except smtplib.SMTPAuthenticationError as error:
        raise MailError(
            f"le serveur refuse l’identifiant ou le mot de passe ({_reply_words(error.smtp_code, error.smtp_error)})",
            retry=True,
        ) from error
    except smtplib.SMTPNotSupportedError as error:
        raise MailError("le serveur ne sait pas identifier Balise (AUTH manque)", retry=True) from error
    except smtplib.SMTPResponseException as error:
        raise MailError(f"le serveur répond {_reply_words(error.smtp_code, error.smtp_error)}", retry=True) from error
    except ssl.SSLCertVerificationError as error:
        raise MailError(f"le certificat du serveur n’est pas reconnu ({error.verify_message})", retry=True) from error
    except (smtplib.SMTPException, OSError) as error:
        raise MailError(
            f"le serveur ne répond pas ({_plain_reply_text(str(error)) or type(error).__name__})", retry=True
        ) from error


def _connect(settings: Settings) -> smtplib.SMTP:
    """Return an open session, over TLS and logged in as the settings say. Raises MailError, SMTPException, OSError."""
    if settings.smtp_tls == "none" and settings.smtp_user:
        raise MailError(NO_PASSWORD_IN_CLEAR, retry=True)
    context = ssl.create_default_context(cafile=None if settings.smtp_ca is None else str(settings.smtp_ca))
    host, port = settings.smtp_host, settings.smtp_port
    if settings.smtp_tls == "tls":
        server: smtplib.SMTP = smtplib.SMTP_SSL(host, port, timeout=SECONDS, context=context)
    else:
        server = smtplib.SMTP(host, port, timeout=SECONDS)
    try:
        server.ehlo_or_helo_if_needed()
        if settings.smtp_tls == "starttls":
            if not server.has_extn("starttls"):
                raise MailError(NO_TLS, retry=True)
            server.starttls(context=context)
            server.ehlo_or_helo_if_needed()
        if settings.smtp_user:
            server.login(settings.smtp_user, settings.smtp_password)
    except BaseException:
        server.close()
        raise
    return server


def _quit_session(server: smtplib.SMTP) -> None:
    """End the session; a message that was taken stays taken, whatever the server says to that."""
    with suppress(smtplib.SMTPException, OSError):
        server.quit()
    server.close()


def _require_accepted(answer: tuple[int, bytes], what: str, *, is_address: bool) -> None:
    code, text = answer
    if not 200 <= code < 300:
        lasts = 500 <= code < 600
        reason = f"le serveur refuse {what} ({_reply_words(code, text)})"
        raise MailError(reason, retry=not (lasts and is_address), is_address=is_address)


def _send_data(server: smtplib.SMTP, message: EmailMessage) -> None:
    """Send the message itself. Raises MailError for a refusal, LostAnswerError where no answer came."""
    try:
        code, text = server.data(message.as_bytes(policy=SMTP))
    except smtplib.SMTPDataError as error:  # DATA itself is refused: nothing has left
        code, text = error.smtp_code, error.smtp_error if isinstance(error.smtp_error, bytes) else b""
    except (smtplib.SMTPException, OSError) as error:
        raise LostAnswerError("le serveur n’a pas dit s’il a pris le message", retry=False) from error
    if code != 250:
        raise MailError(f"le serveur refuse le message ({_reply_words(code, text)})", retry=400 <= code < 500)


def _reply_words(code: int, text: bytes | str) -> str:
    words = text.decode("ascii", "replace") if isinstance(text, bytes) else text
    return f"réponse {code} : {_plain_reply_text(words)}" if _plain_reply_text(words) else f"réponse {code}"


def _plain_reply_text(text: str) -> str:
    return ANY_ADDRESS.sub("cette adresse", UNPRINTABLE.sub(" ", text)[: 2 * REPLY_LENGTH]).strip()[:REPLY_LENGTH]
