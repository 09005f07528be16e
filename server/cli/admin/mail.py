"""`balise admin mail`: the settings of mails, tried by a mail to an address, and what came of the latest ones."""

from argparse import Namespace
from datetime import timedelta
from email.headerregistry import Address
from email.message import EmailMessage
from email.policy import SMTP

from server.base.errors import InvalidFields
from server.base.settings import Settings
from server.cli import CommandError
from server.cli.admin.answer import CommandAnswer
from server.database import Database, utc_now
from server.mails import repository, service, smtp
from server.mails.errors import MailError
from server.web.words import count_with_noun, format_short_time

DAYS, SHOWN = 30, 10
NOT_SET = "aucun serveur de courriel n’est réglé : voyez BALISE_SMTP_HOST, dans la page « Les courriels » des docs."
SUBJECT = "Essai d’envoi de Balise"
TEXT = "Ce courriel vérifie les réglages d’envoi de Balise. Il n’y a rien à faire.\n"


def test_and_report_mail(database: Database, settings: Settings, arguments: Namespace) -> CommandAnswer:
    """Send a test mail to `--to`; always tell the settings and the latest failures."""
    if not smtp.is_smtp_configured(settings):
        raise CommandError(NOT_SET)
    lines = [
        f"Serveur : {settings.smtp_host}, port {settings.smtp_port}, TLS : {settings.smtp_tls}, "
        f"expéditeur : {smtp.sender_address(settings)}."
    ]
    sent_to = ""
    if arguments.to:
        sent_to = _send_test(settings, arguments.to)
        lines.append(f"Le serveur a pris un courriel pour {sent_to} : vérifiez qu’il arrive, et hors des indésirables.")
    since = utc_now() - timedelta(days=DAYS)
    with database.read() as db:
        counts = dict(repository.count_deliveries_by_state(db, since))
        problems = repository.load_delivery_problems(db, since, SHOWN)
    sent, waiting = counts.get("sent", 0), counts.get("waiting", 0)
    refused = counts.get("refused", 0) + counts.get("unknown", 0)
    lines.append(
        f"Depuis {DAYS} jours : {count_with_noun(sent, 'courriel envoyé', 'courriels envoyés')}, {waiting} en attente, "
        f"{count_with_noun(refused, 'échec')}."
    )
    lines += [f"  {format_short_time(delivery.created_at)}, {name} : {delivery.reason}" for delivery, name in problems]
    data = [
        {"at": delivery.created_at, "class": name, "state": delivery.state, "reason": delivery.reason}
        for delivery, name in problems
    ]
    return CommandAnswer(lines, {"test_sent_to": sent_to, "counts": counts, "problems": data})


def _send_test(settings: Settings, text: str) -> str:
    """Send a test mail; return its address. Raises CommandError."""
    try:
        address = service.parse_mail_address(text)
        message = EmailMessage(policy=SMTP)
        message["Subject"] = SUBJECT
        message["From"] = Address("Balise", addr_spec=smtp.sender_address(settings))
        message["To"] = Address(addr_spec=address)
        message["Date"] = utc_now()
        message["Auto-Submitted"] = "auto-generated"
        message.set_content(TEXT, cte="quoted-printable")
        smtp.send_message(settings, message)
    except InvalidFields as refused:
        raise CommandError(f"« {text} » : {refused.problems['address']}") from refused
    except MailError as failure:
        raise CommandError(f"le courriel n’est pas parti : {failure.reason}.") from failure
    return address
