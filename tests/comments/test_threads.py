"""Who may say what of whose work, what is told to whom, and what stays when people and work go."""

from __future__ import annotations

from dataclasses import dataclass, replace
from uuid import UUID, uuid4

import pytest
from sqlalchemy import func, select

from graders.core.contract.findings import Judgement
from graders.core.contract.verdict import Diagnosis
from server.base.errors import Conflict, Invalid, NotFound, RateLimited
from server.base.settings import Settings
from server.classes import service as classes
from server.classes.models import ClassRole, SchoolClass
from server.comments import notes, notes_repository, repository, service
from server.comments.line_tracking import LineFate, LineRange
from server.comments.models import TEXT_LENGTH, Message, Note, NoteReader, Phrase, Thread, ThreadState
from server.comments.schemas import WHOLE_WORK, Conversation, ThreadTarget
from server.database import Database, utc_now
from server.gradebook import service as gradebook
from server.gradebook import student_work
from server.gradebook.schemas import Attempt, GradingResult
from server.identity import repository as identity
from server.identity.models import Account, Role
from server.personal.guest_adoption import adopt_guest_data
from server.submissions.models import Submission
from server.submissions.service import digest_code
from tests.support.classes import new_class, seat
from tests.support.service import EXERCISE, fake_verdict, new_account

CODE = "import numpy\n\ndef f(x):\n    return x + 1\n"


@dataclass
class Room:
    """A class with a student and a teacher, and somebody of another class."""

    database: Database
    settings: Settings
    made: SchoolClass
    teacher: Account
    ada: Account
    other: Account

    def send(self, code: str = CODE, by: Account | None = None, diagnosis: str | None = None) -> UUID:
        verdict = fake_verdict("# outcome: wrong_answer", 1)
        if diagnosis:
            verdict = replace(verdict, diagnosis=Diagnosis(diagnosis, "Erreur", "Pourquoi."))
        with self.database.write() as db:
            author = by or self.ada
            row = {"source": code.encode(), "digest": digest_code(code), "seed": 1}
            sent = Submission(account_id=author.id, exercise=EXERCISE, **row)
            db.add(sent)
            db.flush()
            gradebook.record_grading(db, sent.id, GradingResult(Judgement(verdict), utc_now()))
            return sent.id

    def say(self, by: Account, sent: UUID, target: ThreadTarget = WHOLE_WORK, text: str = "Pourquoi ?") -> Thread:
        with self.database.write() as db:
            attempt = gradebook.find_attempt(db, by, sent)
            return service.begin_thread(db, by, attempt, target, text, self.settings)

    def reply(self, by: Account, thread: Thread, text: str = "Parce que.") -> Thread:
        with self.database.write() as db:
            found = service.find_thread(db, by, thread.id)
            service.reply_to_thread(db, by, found, text, self.settings)
            return found

    def beside(self, sent: UUID) -> list[Conversation]:
        with self.database.read() as db:
            attempt = gradebook.find_attempt(db, self.ada, sent)
            return list(service.load_attempt_conversations(db, Attempt(attempt.submission, attempt.grading)))

    def count(self, table: type) -> int:
        with self.database.read() as db:
            return db.execute(select(func.count()).select_from(table)).scalar_one()


def _room(database: Database, settings: Settings) -> Room:
    teacher, other = new_account(database, Role.teacher, "Mme Martin"), new_account(database, Role.teacher, "M. Autre")
    ada = new_account(database)
    made = new_class(database, teacher)
    new_class(database, other, "PSI")
    seat(database, made, ada)
    return Room(database, settings.model_copy(update={"comment_burst": 1000}), made, teacher, ada, other)


@pytest.fixture
def room(sqlite: Database, settings: Settings) -> Room:
    return _room(sqlite, settings)


@pytest.fixture
def either(database: Database, both: Settings) -> Room:
    """On SQLite, then on PostgreSQL."""
    return _room(database, both)


def test_a_question_waits_is_answered_and_settled_and_an_answer_opens_it_again(either: Room) -> None:
    room = either
    sent = room.send()
    thread = room.say(room.ada, sent, ThreadTarget(check="b"))
    assert (thread.state, thread.by_staff, thread.check_title) == (ThreadState.open, False, "Seconde")
    with room.database.read() as db:
        assert repository.count_open_questions_by_class(db, [room.made.id]) == {room.made.id: 1}
        assert not service.load_unread_threads(db, room.ada)
    answered = room.reply(room.teacher, thread)
    assert answered.state == ThreadState.answered
    with room.database.write() as db:
        (news,) = service.load_unread_threads(db, room.ada)
        assert (news.thread.id, news.text) == (thread.id, "Parce que.")
        service.mark_conversations_seen(db, room.ada.id, [service.load_conversation(db, news.thread)])
    with room.database.write() as db:
        assert not service.load_unread_threads(db, room.ada)
        service.set_settled(service.find_thread(db, room.ada, thread.id), True)
    assert room.reply(room.ada, thread, "Et pourtant").state == ThreadState.open
    with room.database.read() as db:
        found = service.load_thread_page(db, room.made, ThreadState.open, 1)
        assert [(one.student, one.text, one.messages) for one in found.threads] == [("Ada", "Pourquoi ?", 3)]
        assert found.counts == {ThreadState.open: 1, ThreadState.answered: 0, ThreadState.settled: 0}


def test_nobody_else_reads_or_writes(room: Room) -> None:
    bob = seat(room.database, room.made, new_account(room.database, name="Bob"))
    guide = seat(room.database, room.made, new_account(room.database, name="Guide"), ClassRole.assistant)
    sent = room.send()
    thread = room.say(room.ada, sent)
    for stranger in (bob, room.other):
        with pytest.raises(NotFound):
            room.say(stranger, sent)
        with pytest.raises(NotFound):
            room.reply(stranger, thread)
        with room.database.write() as db, pytest.raises(NotFound):
            service.begin_exercise_thread(db, stranger, room.ada.id, EXERCISE, "Bonjour", room.settings)
    room.reply(guide, thread)
    for unknown in (uuid4(), "zut"):
        with room.database.read() as db, pytest.raises(NotFound):
            service.find_thread(db, room.teacher, unknown)


def test_who_has_left_is_read_up_to_then(room: Room) -> None:
    before = room.send()
    thread = room.say(room.ada, before)
    with room.database.write() as db:
        classes.leave_class(db, room.made, room.ada.id)
    after = room.send("y = 2\n")
    with pytest.raises(Conflict):
        room.say(room.ada, after)
    room.reply(room.teacher, thread)
    with pytest.raises(NotFound):
        room.say(room.teacher, after)
    with room.database.read() as db:
        made = db.merge(room.made)
        assert [one.thread.id for one in service.load_thread_page(db, made, None, 1).threads] == [thread.id]
        assert repository.count_open_questions_by_class(db, [made.id]) == {}


#: What a thread cannot be about, and what is no message.
REFUSED = [
    (ThreadTarget(lines=LineRange(0, 1)), "a"),
    (ThreadTarget(lines=LineRange(3, 2)), "a"),
    (ThreadTarget(lines=LineRange(4, 5)), "a"),
    (ThreadTarget(lines=LineRange(-1, 10**9)), "a"),
    (ThreadTarget(check="zut"), "a"),
    (ThreadTarget(check="b' OR 1=1 --\x00"), "a"),
    (WHOLE_WORK, " \r\n "),
    (WHOLE_WORK, "x" * (TEXT_LENGTH + 1)),
    (WHOLE_WORK, "x" * 10**6),
    (WHOLE_WORK, "\ud800"),
]


def test_what_is_not_there_and_what_is_no_message_are_refused(room: Room) -> None:
    sent = room.send()
    for target, text in REFUSED:
        with pytest.raises(Invalid):
            room.say(room.ada, sent, target, text)
    assert room.count(Thread) == room.count(Message) == 0


def test_any_text_is_kept_as_it_is_but_for_what_no_database_keeps(room: Room) -> None:
    text = "<script>alert(1)</script>\r\n\u202e\x00 é 🙂 '; DROP TABLE thread"
    room.say(room.ada, room.send(), text=text)
    with room.database.read() as db:
        kept = db.execute(select(Message.text)).scalar_one()
    assert kept == text.replace("\r\n", "\n").replace("\x00", "␀")


def test_how_much_is_said_is_bounded(room: Room, monkeypatch: pytest.MonkeyPatch) -> None:
    sent = room.send()
    monkeypatch.setattr(service, "MAX_MESSAGES", 2)
    monkeypatch.setattr(service, "MAX_THREADS", 2)
    thread = room.say(room.ada, sent)
    room.reply(room.teacher, thread)
    with pytest.raises(Conflict):
        room.reply(room.ada, thread)
    room.say(room.ada, sent)
    with pytest.raises(Conflict):
        room.say(room.ada, sent)
    room.settings = room.settings.model_copy(update={"comment_burst": 1, "comment_refill_seconds": 1000.0})
    monkeypatch.setattr(service, "MAX_MESSAGES", 20)
    room.reply(room.teacher, thread)
    with pytest.raises(RateLimited):
        room.reply(room.teacher, thread)


def test_a_comment_on_lines_follows_them(room: Room) -> None:
    first = room.send()
    room.say(room.teacher, first, ThreadTarget(lines=LineRange(4, 4)), "Et si x est un tableau ?")
    room.say(room.teacher, first, ThreadTarget(lines=LineRange(1, 1)), "Inutile.")
    settled = room.say(room.teacher, first, ThreadTarget(lines=LineRange(3, 3)), "Bien.")
    with room.database.write() as db:
        service.set_settled(service.find_thread(db, room.teacher, settled.id), True)
    second = room.send("# mieux\ndef f(x):\n    return x + 2\n")
    found = {talk.messages[0].text: (talk.fate, talk.lines, talk.number) for talk in room.beside(second)}
    assert found == {
        "Et si x est un tableau ?": (LineFate.changed, LineRange(3, 3), 1),
        "Inutile.": (LineFate.changed, LineRange(1, 1), 1),
    }
    assert {talk.lines for talk in room.beside(first)} == {LineRange(4, 4), LineRange(1, 1), LineRange(3, 3)}


def test_who_goes_takes_their_words_along_and_a_teacher_s_stay_unsigned(either: Room) -> None:
    room = either
    thread = room.say(room.ada, room.send())
    room.reply(room.teacher, thread)
    with room.database.write() as db:
        notes.save_phrase(db, room.teacher, "Relisez l’énoncé.", EXERCISE, None)
        notes.send_note_to_students(db, room.teacher, room.made, EXERCISE, None, "Bonjour", "", room.settings)
        identity.delete_account(db, room.teacher.id)
    with room.database.read() as db:
        talk = service.load_conversation(db, service.find_thread(db, room.ada, thread.id))
        assert [(said.name, said.message.as_staff) for said in talk.messages] == [("Ada", False), ("", True)]
        assert [one.author for one in notes_repository.load_all_received_notes(db, room.ada.id)] == [""]
    assert room.count(Phrase) == 0
    with room.database.write() as db:
        identity.delete_account(db, room.ada.id)
    assert [room.count(table) for table in (Thread, Message, NoteReader, Note)] == [0, 0, 0, 1]


def test_what_is_said_goes_with_the_submission(room: Room) -> None:
    sent = room.send()
    room.say(room.ada, sent)
    with room.database.write() as db:
        db.delete(db.get(Submission, sent))
    assert [room.count(table) for table in (Thread, Message)] == [0, 0]


def test_a_guest_s_questions_are_those_of_their_account(either: Room) -> None:
    room = either
    guest = seat(room.database, room.made, new_account(room.database, Role.guest, "Invitée"))
    thread = room.say(guest, room.send(by=guest))
    room.reply(room.teacher, thread)
    with room.database.write() as db:
        notes.send_note_to_students(db, room.teacher, room.made, EXERCISE, None, "À tous", "", room.settings)
        adopt_guest_data(db, guest.id, room.ada.id)
    with room.database.read() as db:
        talk = service.load_conversation(db, service.find_thread(db, room.ada, thread.id))
        assert [said.message.author_id for said in talk.messages] == [room.ada.id, room.teacher.id]
        assert len(notes_repository.load_all_received_notes(db, room.ada.id)) == 1
        assert len(service.load_unread_threads(db, room.ada)) == 1


def test_a_word_is_for_those_who_have_the_mistake_now(either: Room) -> None:
    room = either
    students = [
        seat(room.database, room.made, new_account(room.database, name=name)) for name in ("Bob", "Cleo", "Dan")
    ]
    bob, cleo, dan = students
    room.send(by=bob, diagnosis="signe")
    room.send(by=cleo, diagnosis="signe")
    room.send("y = 2\n", by=cleo, diagnosis="autre")
    room.send(by=dan, diagnosis="signe")
    with room.database.write() as db:
        classes.leave_class(db, room.made, dan.id)
        note, count = notes.send_note_to_students(
            db, room.teacher, room.made, EXERCISE, "signe", "Relisez.", "/l20", room.settings
        )
    assert count == 1
    with room.database.read() as db:
        assert notes_repository.load_current_misconceptions(db, room.made.id, EXERCISE) == [
            ("autre", "Erreur", 1),
            ("signe", "Erreur", 1),
        ]
        (tried,), total = student_work.list_attempt_summaries(db, cleo.id, EXERCISE, None, limit=1)
        assert (tried.number, tried.mistake, tried.diagnosis, total) == (2, "Erreur", "autre", 2)
        assert len(student_work.load_attempt_and_previous(db, cleo.id, EXERCISE, None, 2)) == 2
        assert not student_work.load_attempt_and_previous(db, cleo.id, EXERCISE, None, 3)
        sums = student_work.load_work_by_exercise(db, cleo.id, "l20", None)[EXERCISE]
        assert (sums.attempts, sums.best, sums.mistake) == (2, 0.5, "Erreur")
        assert not student_work.load_work_by_exercise(db, cleo.id, "l20", utc_now().replace(year=2000))
    with room.database.write() as db:
        assert [one.seen_at for one in notes_repository.load_received_notes(db, bob.id, EXERCISE)] == [None]
        assert not notes_repository.load_all_received_notes(db, cleo.id)
        notes.mark_note_read(db, bob, note.id)
        for stranger in (cleo, room.other):
            with pytest.raises(NotFound):
                notes.mark_note_read(db, stranger, note.id)
        assert all(note.seen_at for note in notes_repository.load_received_notes(db, bob.id, EXERCISE))
        assert [(told.readers, told.seen) for told in notes_repository.load_class_notes(db, room.made.id)] == [(1, 1)]
        with pytest.raises(Conflict):
            notes.send_note_to_students(db, room.teacher, room.made, EXERCISE, "nul", "Relisez.", "", room.settings)


def test_kept_phrases_come_first_where_they_fit_and_are_one_s_own(room: Room) -> None:
    with room.database.write() as db:
        kept = {
            text: notes.save_phrase(db, room.teacher, text, exercise, misconception)
            for text, exercise, misconception in [
                ("partout", None, None),
                ("ailleurs", "l20/autre", "autre"),
                ("ici", EXERCISE, None),
                ("signe", EXERCISE, "signe"),
            ]
        }
        assert notes.save_phrase(db, room.teacher, " partout ", EXERCISE, None).id == kept["partout"].id
        notes.prepend_phrase(db, room.teacher, kept["partout"].id, "")
        assert notes.prepend_phrase(db, room.teacher, kept["ici"].id, "Voilà.") == "ici\n\nVoilà."
    with room.database.write() as db:
        found = [one.text for one in notes.suggest_phrases(db, room.teacher, EXERCISE, "signe")]
        assert found == ["signe", "ici", "partout", "ailleurs"]
        assert notes.suggest_phrases(db, room.teacher, "l20/autre", "autre")[0].text == "ailleurs"
        assert not notes.suggest_phrases(db, room.other, EXERCISE, "signe")
        with pytest.raises(NotFound):
            notes.prepend_phrase(db, room.other, kept["signe"].id, "")
        with pytest.raises(NotFound):
            notes.delete_phrase(db, room.other, kept["signe"].id)
        notes.delete_phrase(db, room.teacher, kept["signe"].id)
    assert room.count(Phrase) == 3
