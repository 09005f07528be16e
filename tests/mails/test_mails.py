"""Mails of « Après la séance »: asked for, confirmed, sent once by a real SMTP server, stopped at a click."""

from __future__ import annotations

import asyncio
import re
import ssl
import subprocess
from collections.abc import Callable, Iterator
from contextlib import closing
from datetime import datetime, timedelta
from email import message_from_bytes, policy
from email.message import EmailMessage
from functools import partial
from pathlib import Path
from threading import Thread
from typing import Any

import pytest
from aiosmtpd.smtp import SMTP, AuthResult, Envelope, LoginPassword, Session
from sqlalchemy import select, update

from server.base.app_services import get_service
from server.base.settings import Settings
from server.classes.models import ClassRole, SchoolClass
from server.cli.admin import mail as admin_mail
from server.course import Course
from server.database import utc_now
from server.desk.lesson.mail import ReviewMails, latest_week
from server.identity.models import Account, Role
from server.lesson.models import LiveLesson
from server.mails import outbox, service, smtp
from server.mails.errors import MailError
from server.mails.models import MailDelivery, MailState, MailSubscription
from server.mails.post import MailSender
from tests.support.classes import new_class, person, seat
from tests.support.client import TestClient
from tests.support.crowd import Sent, store
from tests.support.service import EXERCISE, Site

ADDRESS = "claire.martin@lycee.example"


class Inbox:
    """Takes mails, but answers as the test says: `replies` by the command that it is asked with."""

    def __init__(self) -> None:
        self.messages: list[EmailMessage] = []
        self.replies: dict[str, str] = {}
        self.hangs_up = False

    async def handle_MAIL(self, _server: SMTP, _session: Session, envelope: Envelope, address: str, _o: Any) -> str:
        envelope.mail_from = address
        return self.replies.get("MAIL", "250 OK")

    async def handle_RCPT(self, _server: SMTP, _session: Session, envelope: Envelope, address: str, _o: Any) -> str:
        envelope.rcpt_tos.append(address)
        return self.replies.get("RCPT", "250 OK")

    async def handle_DATA(self, server: SMTP, _session: Session, envelope: Envelope) -> str:
        if self.hangs_up:
            server.transport.close()
        if "DATA" in self.replies:
            return self.replies["DATA"]
        content = envelope.content
        assert isinstance(content, bytes)
        message = message_from_bytes(content, policy=policy.default)
        assert isinstance(message, EmailMessage)
        self.messages.append(message)
        return "250 OK"


class SmtpServer:
    """A real SMTP server on a free port of this machine, in a thread; `options` are those of `aiosmtpd.smtp.SMTP`."""

    def __init__(self, **options: Any) -> None:
        self.inbox, self.loop = Inbox(), asyncio.new_event_loop()
        protocol = partial(SMTP, self.inbox, hostname="smtp.lycee.example", loop=self.loop, **options)
        starting = self.loop.create_server(protocol, "127.0.0.1", 0)
        self.server = self.loop.run_until_complete(starting)
        self.port = int(self.server.sockets[0].getsockname()[1])
        self.thread = Thread(target=self.loop.run_forever, daemon=True)
        self.thread.start()

    async def _end(self) -> None:
        self.server.close()
        others = asyncio.all_tasks() - {asyncio.current_task()}
        for task in others:
            task.cancel()
        await asyncio.gather(*others, return_exceptions=True)

    def close(self) -> None:
        asyncio.run_coroutine_threadsafe(self._end(), self.loop).result()
        self.loop.call_soon_threadsafe(self.loop.stop)
        self.thread.join()
        self.loop.close()


@pytest.fixture
def served(site: Site) -> Iterator[Inbox]:
    """The inbox of the server that the site is set to send by."""
    with closing(SmtpServer()) as server:
        site.tighten(**settings_of(server, smtp_tls="none"))
        yield server.inbox


def settings_of(server: SmtpServer, **more: Any) -> dict[str, Any]:
    return {"smtp_host": "127.0.0.1", "smtp_port": server.port, "smtp_from": "balise@lycee.example", **more}


class Desk:
    """A teacher with a class, her browser, and the thread that sends mails, at a time that the test chooses."""

    def __init__(self, site: Site) -> None:
        self.site, self.now = site, utc_now()
        self.martin = person(site, Role.teacher, "Mme Martin")
        self.made = new_class(site.database, self.martin.account, "MPSI <b>")
        self.browser = self.martin.browser(site)
        self.path = f"/classes/{self.made.id}"
        self.settings = settings = get_service(site.app, Settings)
        self.post = MailSender(
            site.database, settings, ReviewMails(get_service(site.app, Course), settings),
            clock=lambda: self.now,
        )  # fmt: skip

    def ask(self, address: str = ADDRESS, browser: TestClient | None = None) -> Any:
        return (browser or self.browser).post(f"{self.path}/courriel", data={"action": "recevoir", "adresse": address})

    def confirmed(self, inbox: Inbox) -> None:
        """Asks for the mails, and opens the link of the mail that asks to confirm them."""
        assert self.ask().status_code == 303
        self.now = utc_now()
        assert self.post.work() == 1
        assert TestClient(self.site.app).post(link_of(inbox.messages.pop(), "confirmer")).status_code == 200

    def lesson(self, minutes: int = 5) -> LiveLesson:
        """A lesson that ends in so many minutes; time goes on until then."""
        ended = utc_now() + timedelta(minutes=minutes)
        with self.site.database.write() as db:
            lesson = LiveLesson(
                class_id=self.made.id, exercises=[EXERCISE], started_at=ended - timedelta(hours=1), ended_at=ended
            )
            db.add(lesson)
        self.now = ended + timedelta(seconds=1)
        return lesson

    def deliveries(self) -> list[MailDelivery]:
        with self.site.database.read() as db:
            query = select(MailDelivery).where(MailDelivery.key != service.CONFIRMATION).order_by(MailDelivery.key)
            return list(db.execute(query).scalars())

    def page(self) -> str:
        return str(self.browser.get(f"{self.path}/semaine").text)


@pytest.fixture
def desk(site: Site, served: Inbox) -> Desk:
    return Desk(site)


def text_of(message: EmailMessage, kind: str = "plain") -> str:
    part = message.get_body((kind,))
    assert part is not None
    return str(part.get_content())


def link_of(message: EmailMessage, action: str) -> str:
    """Return the path of a link, which the text and the HTML have."""
    found = re.search(rf"http://testserver(/courriel/[0-9a-f-]+/{action}/[0-9a-f]+)", text_of(message))
    assert found, text_of(message)
    assert found[0] in text_of(message, "html")
    return found[1]


def test_nothing_is_proposed_without_a_server(site: Site) -> None:
    desk = Desk(site)
    assert "Recevoir cette page par courriel" not in desk.page()
    assert desk.ask().status_code == 404
    assert desk.post.work() == 0


def test_an_address_is_confirmed_by_its_owner_before_anything_else_goes_there(desk: Desk, served: Inbox) -> None:
    desk.lesson()
    assert "Recevoir cette page par courriel" in desk.page()
    assert desk.ask().headers["location"] == f"{desk.path}/semaine#courriel"
    assert desk.post.work() == 1
    (asked,) = served.messages
    assert asked["To"] == ADDRESS
    assert asked["From"] == "Balise <balise@lycee.example>"
    assert "oubliée dans sept jours" in text_of(asked)
    assert "MPSI &lt;b&gt;" in text_of(asked, "html")
    assert f"parti vers <strong>{ADDRESS}</strong>" in desk.page()
    link = link_of(asked, "confirmer")
    stranger = TestClient(desk.site.app)
    assert "Confirmer l’adresse" in stranger.get(link).text
    assert desk.post.work() == 0, "a program that follows links confirms nothing"
    for forged in (link[:-1] + ("0" if link[-1] != "0" else "1"), link.replace("confirmer", "arreter"), f"{link}é"):
        assert stranger.post(forged).status_code == 404, forged
    assert "C’est fait" in stranger.post(link).text
    assert f"Envoyée à <strong>{ADDRESS}</strong>" in desk.page()
    desk.now = max(desk.now, utc_now() + timedelta(minutes=1))
    assert desk.post.work() == 1, "the lesson that ends later than the confirmation"


def test_a_lesson_is_told_once_with_the_names_of_the_page_and_stopped_by_the_link(desk: Desk, served: Inbox) -> None:
    ada = person(desk.site, name="Ada <i>").account
    seat(desk.site.database, desk.made, ada)
    desk.confirmed(served)
    tries = [Sent(ada.id, EXERCISE, utc_now() + timedelta(seconds=n), 0.0, "m", f"secret = {n}\n") for n in range(4)]
    store(desk.site.database, tries)
    desk.lesson()
    assert desk.post.work() == 1
    assert desk.post.work() == 0
    (message,) = served.messages
    assert message["Subject"].startswith("Après la séance, MPSI <b>, séance du")
    assert message["Auto-Submitted"] == "auto-generated"
    assert "Ada <i>" in text_of(message)
    assert "Ada &lt;i&gt;" in text_of(message, "html")
    assert "secret" not in message.as_string(), "no code of a student"
    assert f"http://testserver{desk.path}/seance/" in text_of(message)
    stop = link_of(message, "arreter")
    assert message["List-Unsubscribe"] == f"<http://testserver{stop}>"
    provider = TestClient(desk.site.app)
    assert provider.post(stop, data={"List-Unsubscribe": "One-Click"}).status_code == 200
    assert provider.post(stop).status_code == 404
    desk.lesson(10)
    assert desk.post.work() == 0
    assert "Recevoir par courriel</button>" in desk.page()


def test_a_click_on_the_page_stops_them(desk: Desk, served: Inbox) -> None:
    desk.confirmed(served)
    assert desk.browser.post(f"{desk.path}/courriel", data={"action": "arreter"}).status_code == 303
    desk.lesson()
    assert (desk.post.work(), served.messages) == (0, [])


def test_a_week_is_told_on_monday_where_there_is_something_to_tell(desk: Desk, served: Inbox) -> None:
    sunday = datetime.fromisoformat("2026-11-29T23:30:00+00:00")  # Monday 0:30 in Paris
    monday = datetime.fromisoformat("2026-11-30T05:00:00+00:00")
    assert latest_week(sunday) == monday - timedelta(days=7)
    assert latest_week(monday) == monday
    assert latest_week(datetime.fromisoformat("2026-10-26T12:00:00+00:00")).isoformat() == "2026-10-26T06:00:00+01:00"
    desk.confirmed(served)
    with desk.site.database.write() as db:
        db.execute(update(MailSubscription).values(confirmed_at=sunday))
    desk.now = monday + timedelta(minutes=1)
    assert desk.post.work() == 0
    (empty,) = desk.deliveries()
    assert (empty.key, empty.state) == ("semaine/2026-W49", MailState.dropped), "an idle week is not told, nor again"
    ada = person(desk.site, name="Ada").account
    seat(desk.site.database, desk.made, ada)
    desk.now += timedelta(days=7)
    begun = desk.now - timedelta(days=2)
    tries = [Sent(ada.id, EXERCISE, begun + timedelta(minutes=n), 0.0, "m", f"x = {n}\n") for n in range(4)]
    store(desk.site.database, tries)
    assert desk.post.work() == 1
    assert "La semaine, MPSI <b>, jusqu’au 07/12/2026" in served.messages[0]["Subject"]
    with desk.site.database.write() as db:
        db.execute(update(SchoolClass).values(archived_at=utc_now()))
    desk.now += timedelta(days=7)
    assert desk.post.work() == 0


def leaves(desk: Desk) -> None:
    seat(desk.site.database, desk.made, desk.martin.account, as_=ClassRole.student)


def is_disabled(desk: Desk) -> None:
    with desk.site.database.write() as db:
        db.execute(update(Account).where(Account.id == desk.martin.id).values(disabled_at=utc_now()))


@pytest.mark.parametrize("lose", [leaves, is_disabled])
def test_who_may_not_read_the_class_any_more_receives_nothing(
    desk: Desk, served: Inbox, lose: Callable[[Desk], None]
) -> None:
    desk.confirmed(served)
    desk.lesson()
    lose(desk)
    assert (desk.post.work(), served.messages) == (0, [])


def test_a_refused_address_is_told_to_the_teacher_and_the_administrator(desk: Desk, served: Inbox) -> None:
    desk.confirmed(served)
    served.replies["RCPT"] = f"550 <{ADDRESS}> unknown"
    desk.lesson()
    assert desk.post.work() == 0
    (refused,) = desk.deliveries()
    assert (refused.state, refused.tries) == (MailState.refused, 1)
    assert "le serveur refuse l’adresse (réponse 550 : cette adresse unknown)" in refused.reason
    assert "550" in desk.page()
    log = person(desk.site, Role.administrator).browser(desk.site).get("/administration/journal").text
    assert "réponse 550" in log
    answer = admin_mail.test_and_report_mail(desk.site.database, desk.settings, Arguments(""))
    assert "1 échec" in "\n".join(answer.lines)
    assert "réponse 550" in answer.lines[-1]


def test_a_server_that_refuses_is_tried_again_a_bounded_number_of_times(desk: Desk, served: Inbox) -> None:
    desk.confirmed(served)
    served.replies["DATA"] = "451 later"
    desk.lesson()
    for tries in range(1, outbox.MAX_TRIES + 1):
        assert desk.post.work() == 0
        assert desk.post.work() == 0, "not before the pause is over"
        assert desk.deliveries()[0].tries == tries
        desk.now += outbox.retry_delay(tries)
    assert desk.deliveries()[0].state == MailState.refused
    served.replies.clear()
    desk.now += timedelta(days=1)
    assert desk.post.work() == 0
    assert served.messages == []


def test_a_message_whose_answer_is_lost_is_never_sent_twice(desk: Desk, served: Inbox) -> None:
    desk.confirmed(served)
    served.hangs_up = True
    desk.lesson()
    assert desk.post.work() == 0
    assert desk.deliveries()[0].state == MailState.unknown
    served.hangs_up = False
    desk.now = latest_week(desk.now + timedelta(days=7)) + timedelta(hours=1)  # a Monday with nothing to tell
    assert desk.post.work() == 0
    assert {MailState(mail.state) for mail in desk.deliveries()} == {MailState.unknown, MailState.dropped}
    assert "peut-être arrivé" in desk.page()


def test_a_process_that_dies_after_the_handover_sends_nothing_twice(desk: Desk, served: Inbox) -> None:
    desk.confirmed(served)
    desk.lesson()

    def die(_settings: Settings, _message: EmailMessage, on_handover: Callable[[], None]) -> None:
        on_handover()
        raise KeyboardInterrupt

    dying = MailSender(
        desk.site.database, desk.settings, ReviewMails(get_service(desk.site.app, Course), desk.settings),
        die, lambda: desk.now,
    )  # fmt: skip
    with pytest.raises(KeyboardInterrupt):
        dying.work()
    assert desk.post.work() == 0
    assert desk.deliveries()[0].state == MailState.handed
    desk.now += timedelta(days=1)
    assert (desk.post.work(), served.messages) == (0, [])
    assert desk.deliveries()[0].state == MailState.unknown


def test_a_mail_that_is_stopped_while_it_leaves_does_not_leave(desk: Desk, served: Inbox) -> None:
    desk.confirmed(served)
    desk.lesson()

    def stop_meanwhile(settings: Settings, message: EmailMessage, on_handover: Callable[[], None]) -> None:
        with desk.site.database.write() as db:
            service.delete_subscription(db, desk.made.id, desk.martin.id)
        smtp.send_message(settings, message, on_handover)

    post = MailSender(
        desk.site.database, desk.settings, ReviewMails(get_service(desk.site.app, Course), desk.settings),
        stop_meanwhile, lambda: desk.now,
    )  # fmt: skip
    post.work()
    assert served.messages == []


def test_who_may_ask_and_for_which_addresses(desk: Desk, served: Inbox) -> None:
    ada = person(desk.site)
    seat(desk.site.database, desk.made, ada.account)
    assert desk.ask(browser=ada.browser(desk.site)).status_code == 403
    assert desk.ask(browser=person(desk.site, Role.teacher).browser(desk.site)).status_code == 404
    for wrong in (
        "",
        "claire",
        "é@lycee.example",
        "a@b",
        "a@b.c\r\nBcc: x@y.zz",
        "<a@b.cd>",
        "a..b@lycee.example",
        "a@" + "b." * 200 + "fr",
    ):
        refused = desk.ask(wrong)
        assert refused.status_code == 422, wrong
        assert "Ce n’est pas une adresse électronique" in refused.text
    for _ in range(service.CONFIRMATIONS.burst):
        assert desk.ask().status_code == 303
    assert desk.ask("other@lycee.example").status_code == 429, "of one account, to whatever addresses"
    other = person(desk.site, Role.teacher)
    seat(desk.site.database, desk.made, other.account, as_=ClassRole.teacher)
    assert desk.ask(browser=other.browser(desk.site)).status_code == 429, "of one address, by whatever accounts"
    desk.now = utc_now()
    assert desk.post.work() == 1, "the latest request alone"


def test_a_mail_goes_over_tls_to_a_server_that_is_known(settings: Settings, tmp_path: Path) -> None:
    key, certificate = tmp_path / "key.pem", tmp_path / "cert.pem"
    subject = ["-subj", "/CN=127.0.0.1", "-addext", "subjectAltName=IP:127.0.0.1", "-days", "2", "-nodes"]
    curve = ["-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1"]
    command = ["openssl", "req", "-x509", *curve, *subject, "-keyout", str(key), "-out", str(certificate)]
    subprocess.run(command, check=True, capture_output=True)
    context = ssl.create_default_context(ssl.Purpose.CLIENT_AUTH)
    context.load_cert_chain(certificate, key)
    message = EmailMessage(policy=policy.SMTP)
    message["To"] = ADDRESS
    message.set_content("Bonjour\n.\nfin", cte="quoted-printable")

    def authenticate(_s: SMTP, _session: Session, _e: Envelope, _mechanism: str, data: LoginPassword) -> AuthResult:
        return AuthResult(success=data.password == b"secret", handled=False)

    with closing(SmtpServer(tls_context=context, auth_required=True, authenticator=authenticate)) as server:

        def send(**more: Any) -> str:
            values = settings_of(server, smtp_ca=certificate, smtp_user="balise", smtp_password="secret") | more
            try:
                smtp.send_message(settings.model_copy(update=values), message)
            except MailError as error:
                return error.reason
            return ""

        assert send() == ""
        assert text_of(server.inbox.messages[0]).splitlines() == ["Bonjour", ".", "fin"]
        assert "certificat du serveur n’est pas reconnu" in send(smtp_ca=None)
        assert "refuse l’identifiant ou le mot de passe (réponse 535" in send(smtp_password="faux")
        assert "jamais sans TLS" in send(smtp_tls="none")
        assert len(server.inbox.messages) == 1
    with closing(SmtpServer()) as plain:
        assert "n’offre pas STARTTLS" in send(**settings_of(plain))
    assert "ne répond pas" in send()
    assert "ne répond pas" in send(smtp_host="nowhere.invalid")


class Arguments:
    """Of `balise admin mail`."""

    def __init__(self, to: str) -> None:
        self.to = to
