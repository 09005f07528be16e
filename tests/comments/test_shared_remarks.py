"""A remark on what students hand in together: it is new to each of them until they have read it themselves."""

from __future__ import annotations

from datetime import datetime, timedelta
from uuid import UUID

import pytest

from graders.core.contract.findings import Judgement
from server.assignments.models import Mode, TeamMember
from server.comments import service
from server.comments.schemas import WHOLE_WORK
from server.database import utc_now
from server.gradebook import service as gradebook
from server.gradebook.schemas import GradingResult
from server.identity.models import Account, Role
from server.personal.guest_adoption import adopt_guest_data
from server.submissions.models import Submission
from server.submissions.service import digest_code
from tests.support.classes import Person, person, seat
from tests.support.marks import DAY, POSES, Term
from tests.support.service import Site, fake_verdict, new_account

NEW = '<span class="badge">nouveau</span>'


class Pair:
    """Two students who hand in together, with an attempt of Ada's and a remark of the teacher's on it."""

    def __init__(self, site: Site) -> None:
        self.site = site
        self.term = Term.begin(site.database, person(site, Role.teacher, "Mme Martin").account)
        self.ada, self.blaise = person(site), person(site)
        now = utc_now()
        self.work = self.term.assignment(team_size=2, opens_at=now - 2 * DAY, due_at=now + DAY, closes_at=None)
        for student in (self.ada, self.blaise):
            seat(site.database, self.term.made, student.account)
            self.join(student.account)
        self.sent = self.send(now - DAY / 2)
        self.remark()

    def send(self, at: datetime) -> UUID:
        row = {"exercise": POSES, "source": b"x = 1\n", "digest": digest_code("x = 1\n"), "seed": 1, "created_at": at}
        with self.site.database.write() as db:
            sent = Submission(account_id=self.ada.id, **row)
            db.add(sent)
            db.flush()
            judgement = Judgement(fake_verdict("# outcome: wrong_answer", 1))
            gradebook.record_grading(db, sent.id, GradingResult(judgement, at))
            return sent.id

    def join(self, account: Account) -> None:
        with self.site.database.write() as db:
            row = {"team_id": self.ada.id, "account_id": account.id, "since": utc_now() - DAY}
            db.add(TeamMember(assignment_id=self.work.id, **row))

    def remark(self, sent: UUID | None = None) -> None:
        with self.site.database.write() as db:
            attempt = gradebook.find_attempt(db, self.term.teacher, sent or self.sent)
            service.begin_thread(db, self.term.teacher, attempt, WHOLE_WORK, "Relisez.", self.site.settings)

    def unread(self, account: Account) -> int:
        with self.site.database.read() as db:
            return len(service.load_unread_threads(db, account))

    def is_told(self, student: Person, path: str) -> bool:
        return NEW in student.browser(self.site).get(path).text


@pytest.fixture
def pair(site: Site) -> Pair:
    return Pair(site)


def test_each_reads_for_themselves(pair: Pair) -> None:
    ada, blaise, attempt = pair.ada, pair.blaise, f"/soumissions/{pair.sent}"
    pages = ("/classes", "/l20/exercices/poses")
    assert [pair.is_told(student, path) for student in (ada, blaise) for path in pages] == [True] * 4
    assert f'href="{attempt}#fil-' in blaise.browser(pair.site).get("/classes").text
    assert [pair.is_told(blaise, attempt), pair.is_told(blaise, attempt)] == [True, False]
    assert [pair.is_told(student, path) for student in (ada, blaise) for path in pages] == [True, True, False, False]
    assert [pair.is_told(ada, attempt), pair.is_told(ada, "/classes")] == [True, False]
    pair.remark()
    assert (pair.unread(ada.account), pair.unread(blaise.account)) == (1, 1)
    assert pair.unread(pair.term.teacher) == 0


def test_a_remark_is_for_those_who_were_together_and_may_see_the_work(pair: Pair) -> None:
    site, term, (ada, blaise) = pair.site, pair.term, (pair.ada.account, pair.blaise.account)
    alone = pair.send(utc_now() - 1.5 * DAY)
    pair.remark(alone)
    assert (pair.unread(ada), pair.unread(blaise)) == (2, 1)
    now = utc_now()
    test = term.assignment("Contrôle", {POSES: 1.0}, mode=Mode.test, opens_at=now - DAY, due_at=None, closes_at=None)
    term.sit(test, blaise)
    assert (pair.unread(ada), pair.unread(blaise)) == (2, 0), "the test withholds what the pair has sent"
    with site.database.write() as db:
        db.delete(db.merge(test))
    with site.database.write() as db:
        db.get_one(type(pair.work), pair.work.id).removed_at = utc_now()
    assert (pair.unread(ada), pair.unread(blaise)) == (2, 0)


def test_a_guest_s_readings_go_to_their_account(pair: Pair) -> None:
    site, term = pair.site, pair.term
    guest = seat(site.database, term.made, new_account(site.database, Role.guest, "Invitée"))
    pair.join(guest)
    blaise = pair.blaise.account
    with site.database.write() as db:
        for row in service.load_unread_threads(db, guest):
            service.mark_conversations_seen(db, guest.id, [service.load_conversation(db, row.thread)])
        own = service.load_account_comments(db, guest.id)
        assert [name for name, at in own.shared_readings if utc_now() - at < timedelta(minutes=5)] == [POSES]
        adopt_guest_data(db, guest.id, blaise.id)
    assert pair.unread(blaise) == 0
