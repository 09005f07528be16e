"""Answers and choices: stored, taken back, given to an account that a guest becomes."""

from __future__ import annotations

from server.database import Database
from server.identity.models import Account
from server.recall import repository
from server.recall.models import QuestionKind, RecallAnswer


def test_a_guest_gives_its_answers_and_the_choices_not_made_yet(sqlite: Database) -> None:
    guest, pupil = Account(name="invité"), Account(name="Ada", role="student")
    with sqlite.write() as db:
        db.add_all([guest, pupil])
        db.flush()
        repository.add_answer(
            db,
            RecallAnswer(
                account_id=guest.id, subject="degres", kind=QuestionKind.hunt, exercise="l20/poses",
                misconception="degres_dans_cos", is_right=True,
            ),
        )  # fmt: skip
        repository.save_choice(db, guest.id, "reminders", "off")
        repository.save_choice(db, guest.id, "path:l20", "lycee")
        repository.save_choice(db, pupil.id, "path:l20", "prepa")
        repository.move_answers_and_choices(db, guest.id, pupil.id)
    with sqlite.read() as db:
        assert [answer.subject for answer in repository.load_recall_answers(db, pupil.id)] == ["degres"]
        assert repository.load_choices(db, pupil.id) == {"reminders": "off", "path:l20": "prepa"}
    with sqlite.write() as db:
        repository.save_choice(db, pupil.id, "path:l20", "")
        repository.save_choice(db, pupil.id, "reminders", "later")
        assert repository.load_choices(db, pupil.id) == {"reminders": "later"}
