"""The test and the saved work that the form of an exercise was drawn for, checked when it comes back.

Both are hidden fields of the form; a form without them (a program's) is taken as it is.
"""

from __future__ import annotations

from sqlalchemy.orm import Session
from starlette.datastructures import FormData

from server.assignments import feedback, sittings
from server.assignments.feedback import FeedbackHolds
from server.assignments.sittings import StaleWorkError
from server.base.arrival import arrival_time
from server.course import Exercise
from server.identity.models import Account
from server.web.form_identity import FormRefusal, resendable_text_fields

TESTS_FIELD = "controle"
VERSION_FIELD = "depuis"
BEGUN_SINCE = (
    "Vous composez maintenant le contrôle « {title} » : cet envoi y compterait, et son résultat resterait caché "
    "jusqu’à la publication. Rien n’a été envoyé."
)
ENDED_SINCE = (
    "Le contrôle pour lequel cette page était ouverte est terminé, et ses résultats sont publiés : cet envoi serait un "
    "entraînement, et n’y compterait pas. Rien n’a été envoyé."
)
SEND_IN_TEST = "Envoyer dans le contrôle"
SEND_AS_TRAINING = "Envoyer comme entraînement"
SAVE_MINE = "Enregistrer ma version"


class RunningTestsChanged(FormRefusal):
    """A test has begun or ended since the page was drawn: the attempt would count for something else."""

    slug = "autre-situation"
    title = "La situation a changé"


class SavedWorkChanged(FormRefusal):
    slug = "autre-version"
    title = "Modifié ailleurs"


def running_tests_key(holds: FeedbackHolds) -> str:
    """Return the running tests of an exercise as one field; empty where none runs."""
    return " ".join(sorted(str(test.assignment_id) for test in holds.running_tests))


def require_same_tests(db: Session, account: Account, exercise: Exercise, form: FormData) -> None:
    """Raise RunningTestsChanged for a form drawn while other tests ran, or none."""
    holds = feedback.load_holds_at(db, account.id, exercise.id, arrival_time())
    key = running_tests_key(holds)
    if form.get(TESTS_FIELD, key) == key or holds.submission_refusal:  # whoever may not send at all is told so
        return
    running = holds.running_tests
    raise RunningTestsChanged(
        BEGUN_SINCE.format(title=running[0].title) if running else ENDED_SINCE,
        resendable_text_fields(form),
        account=account,
        button=SEND_IN_TEST if running else SEND_AS_TRAINING,
        replacements={TESTS_FIELD: key},
    )


def build_stale_work_refusal(
    error: StaleWorkError, account: Account, form: FormData, other_text: str
) -> SavedWorkChanged:
    """Return the refusal of work that would replace `other_text`, saved meanwhile."""
    return SavedWorkChanged(
        error.detail,
        resendable_text_fields(form),
        account=account,
        button=SAVE_MINE,
        replacements={VERSION_FIELD: sittings.saved_work_version(error.saved)},
        other_text=other_text,
    )


def read_base_version(form: FormData) -> str | None:
    version = form.get(VERSION_FIELD)
    return version if isinstance(version, str) else None
