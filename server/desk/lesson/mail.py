"""« Après la séance » by mail: which pages are due to whom, and each page as a message."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from datetime import datetime, timedelta
from email.headerregistry import Address
from email.message import EmailMessage
from email.policy import SMTP
from uuid import UUID

from sqlalchemy.orm import Session

from server.base import school_time
from server.base.errors import NotFound
from server.base.settings import Settings
from server.base.validation import parse_uuid
from server.course import Course
from server.database import Database
from server.desk.lesson.review import ReviewPage, review_page
from server.desk.views import class_href
from server.lesson import repository as lessons
from server.lesson.service import lesson_end
from server.mails import repository, service, smtp
from server.mails.outbox import OutgoingMail
from server.mails.post import MailSender
from server.rights import service as rights
from server.rights.models import Right
from server.rights.service import ClassAccess
from server.text.plain import show_invisible_characters
from server.web.rendering import jinja_environment
from server.web.words import count_with_noun, format_long_time, format_short_time

LESSON, WEEK = "seance/", "semaine/"
#: A page that could not be queued for so long is told no more: it is not of tomorrow.
WINDOW = timedelta(days=1)
WEEK_HOUR = 6  # of Monday, on the school's clock
SUBJECT_LENGTH = 150


def latest_week(now: datetime) -> datetime:
    """Return the latest Monday at six on the school's clock."""
    local = school_time.to_local(now)
    monday = school_time.to_local(school_time.shift_days(now, -local.weekday()))
    monday = monday.replace(hour=WEEK_HOUR, minute=0, second=0, microsecond=0)
    return monday if monday <= local else school_time.shift_days(monday, -7)


class ReviewMails:
    """The mails of « Après la séance »: one after each lesson, one a week where there is something to tell.

    Implements `server.mails.post.MailComposer`.
    """

    def __init__(self, course: Course, settings: Settings) -> None:
        self._course, self._settings = course, settings

    def list_due(self, db: Session, now: datetime) -> Collection[tuple[UUID, str]]:
        """Return the pages that are due and not queued yet: subscription and key."""
        confirmed = repository.load_confirmed_subscriptions(db)
        if not confirmed:
            return ()
        ended: dict[UUID, list[tuple[str, datetime]]] = {}
        for lesson in lessons.load_lessons_ended_between(db, {row.class_id for row, _ in confirmed}, now - WINDOW, now):
            ended.setdefault(lesson.class_id, []).append((f"{LESSON}{lesson.id}", lesson_end(lesson)))
        week = latest_week(now)
        of_week = [(f"{WEEK}{school_time.to_local(week):%G-W%V}", week)] if now - week < WINDOW else []
        due = {
            (row.id, key)
            for row, since in confirmed
            for key, at in (*ended.get(row.class_id, ()), *of_week)
            if at >= since
        }
        return due - repository.load_queued_mail_keys(db, {name for name, _ in due})

    def compose(self, db: Session, sending: OutgoingMail, now: datetime) -> EmailMessage | None:
        """Return the message; None where nothing is to be told, or its reader may not read the work any more."""
        try:
            access = rights.load_class_access(db, sending.account, sending.subscription.class_id)
        except NotFound:
            return None
        is_over = sending.account.disabled_at is not None or access.school_class.archived_at is not None
        if is_over or not access.has(Right.read_work):
            return None
        if sending.key == service.CONFIRMATION:
            return self._write_mail(sending, access, "confirm", "Confirmer l’envoi de « Après la séance »", now, {})
        if sending.key.startswith(WEEK):
            page = review_page(db, self._course, access, now, None)
            tells = bool(page.to_see or page.to_explain or page.at_fault or page.overcome)
            name, title = "La semaine", f"jusqu’au {format_short_time(now)}"
            href = f"{class_href(access.school_class)}/semaine"
        else:
            lesson_id = parse_uuid(sending.key.removeprefix(LESSON), service.UNKNOWN_LINK)
            lesson = lessons.find_lesson(db, access.school_class.id, lesson_id)
            if lesson is None:
                return None
            page, tells = review_page(db, self._course, access, now, lesson), True
            name, title = "Après la séance", f"séance du {format_short_time(lesson.started_at)}"
            href = f"{page.head.href}/seance/{lesson.id}"
        if not tells:
            return None
        subject = f"{name}, {access.school_class.name}, {title}"
        return self._write_mail(
            sending,
            access,
            "review",
            subject,
            now,
            {"page": page, "href": href, "started": format_short_time(page.since), **_review_counts_in_words(page)},
        )

    def _write_mail(
        self, sending: OutgoingMail, access: ClassAccess, template: str, subject: str, now: datetime,
        values: Mapping[str, object],
    ) -> EmailMessage:  # fmt: skip
        subscription = sending.subscription
        stop = f"{subscription.service_url}{service.signed_link_href(subscription, service.STOP)}"
        context = {
            "base": subscription.service_url,
            "class_name": access.school_class.name,
            "confirm": f"{subscription.service_url}{service.signed_link_href(subscription, service.CONFIRM)}",
            "stop": stop,
            "when": format_long_time(now),
            **values,
        }
        jinja, sender = jinja_environment(), smtp.sender_address(self._settings)
        message = EmailMessage(policy=SMTP)
        message["Subject"] = " ".join(show_invisible_characters(subject).split())[:SUBJECT_LENGTH]
        message["From"] = Address("Balise", addr_spec=sender)
        message["To"] = Address(addr_spec=subscription.address)
        message["Date"] = now
        message["Message-ID"] = f"<{sending.id}@{sender.rpartition('@')[2]}>"
        message["Auto-Submitted"] = "auto-generated"
        message["List-Unsubscribe"] = f"<{stop}>"
        message["List-Unsubscribe-Post"] = "List-Unsubscribe=One-Click"
        message["Content-Language"] = "fr"
        message.set_content(jinja.get_template(f"mails/{template}.txt").render(context), cte="quoted-printable")
        html = jinja.get_template(f"mails/{template}.html").render(context)
        message.add_alternative(html, subtype="html", cte="quoted-printable")
        return message


def _review_counts_in_words(page: ReviewPage) -> Mapping[str, Sequence[str]]:
    """Return the first line of a mail: what the page holds, in numbers."""
    counts = (
        (len(page.to_see) + len(page.more_to_see), "élève à voir", "élèves à voir"),
        (
            len(page.to_explain) + page.more_to_explain,
            "erreur à expliquer de nouveau",
            "erreurs à expliquer de nouveau",
        ),
        (len(page.at_fault), "énoncé à revoir", "énoncés à revoir"),
    )
    return {"summary": [count_with_noun(count, singular, many) for count, singular, many in counts if count]}


def start_mails(database: Database, settings: Settings, course: Course) -> Callable[[], None]:
    """Send mails from a thread of this process, where a server takes them; return what stops it."""
    if not smtp.is_smtp_configured(settings):
        return lambda: None
    return MailSender(database, settings, ReviewMails(course, settings)).start()
