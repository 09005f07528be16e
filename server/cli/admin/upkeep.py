"""`balise admin …` on what is kept: standings, what is to be erased, what is to be graded."""

from argparse import Namespace
from datetime import timedelta

from server.audit.models import AuditAction
from server.base.settings import Settings
from server.cli import CommandError
from server.cli.admin import journal
from server.cli.admin.answer import CommandAnswer, account_json, account_label
from server.course import Course
from server.database import Database, utc_now
from server.gradebook import requeuing
from server.gradebook import service as gradebook
from server.identity import links
from server.personal import erasures
from server.personal.service import PURGE_BATCH, PersonalDataService
from server.queue.interfaces import NullNotifier
from server.queue.service import TableQueue
from server.submissions.service import SubmissionService
from server.web.words import count_with_noun


def recount_standings(database: Database, _settings: Settings, _arguments: Namespace) -> CommandAnswer:
    total, changed = gradebook.rebuild_all_standings(database)
    journal.record_action_in_own_transaction(database, AuditAction.standings_rebuilt, after={"corrected": changed})
    corrected = count_with_noun(changed, "ligne corrigée", "lignes corrigées")
    line = f"Bilans refaits d’après l’historique des corrections : {corrected}, {total} en tout."
    return CommandAnswer([line], {"standings": total, "changed": changed})


def erase_expired_students(database: Database, settings: Settings, arguments: Namespace) -> CommandAnswer:
    """Without `--yes`, only tells."""
    if not (settings.left_days or settings.silent_days):
        raise CommandError("rien ne fixe de durée : voyez BALISE_LEFT_DAYS et BALISE_SILENT_DAYS dans le README.")
    personal = _personal_data_service(database, settings)
    found = personal.erase_expired_students(utc_now()) if arguments.yes else personal.find_expired_students(utc_now())
    if arguments.yes:
        journal.record_action_in_own_transaction(database, AuditAction.accounts_purged, after={"accounts": len(found)})
    more = len(found) == PURGE_BATCH
    end = (
        count_with_noun(len(found), "compte effacé", "comptes effacés")
        if arguments.yes
        else _accounts_to_erase_in_words(len(found))
    )
    lines = [
        *(f"  {account_label(account)}" for account in found),
        f"{end}{' ; recommencez pour la suite' if more else ''}.",
    ]
    return CommandAnswer(lines, {"accounts": list(map(account_json, found)), "erased": arguments.yes, "more": more})


def _accounts_to_erase_in_words(count: int) -> str:
    counted = count_with_noun(count, "compte à effacer", "comptes à effacer")
    return f"{counted} : le service le fait de lui-même, --yes aussi"


def erase_student_on_request(database: Database, settings: Settings, arguments: Namespace) -> CommandAnswer:
    """Erase a student on request; without `--yes`, only tell what would go. With `--cancel`, cancel a request."""
    now = utc_now()
    with database.read() as db:
        account = links.find_account_by_login_or_id(db, arguments.login)
        erasures.require_erasable_student(db, account)
        shown = erasures.preview_erasure(db, account, None, now)
    person = account_label(account)
    if arguments.cancel:
        with database.write() as db:
            erasures.cancel_erasure(db, account, None, account)
            journal.record_action(db, AuditAction.erasure_cancelled, account)
        return CommandAnswer([f"{person} : effacement annulé."], {**account_json(account), "cancelled": True})
    counts = [
        count_with_noun(shown.attempts, "essai"),
        count_with_noun(shown.marks, "note saisie", "notes saisies"),
        count_with_noun(shown.messages, "message"),
        count_with_noun(shown.sittings, "contrôle commencé", "contrôles commencés"),
        count_with_noun(shown.classes, "classe"),
    ]
    lines = [f"{person} : {', '.join(counts)}. Restent le journal des classes, sans son nom, et les sauvegardes."]
    if arguments.yes:
        journal.record_action_in_own_transaction(
            database, AuditAction.erasure_requested, account, after={"attempts": shown.attempts}
        )
    done = arguments.yes and _personal_data_service(database, settings).erase_on_request(account.id)
    if shown.tests:
        when = f"à leur publication, et au plus tard dans {count_with_noun(settings.erasure_days, 'jour')}"
        lines.append(f"Résultats à publier d’abord : {', '.join(shown.tests)}. L’effacement se fait {when}.")
    end = "effacé" if done else "effacement demandé" if arguments.yes else "rien n’est effacé sans --yes"
    data = {**account_json(account), "attempts": shown.attempts, "marks": shown.marks, "messages": shown.messages}
    return CommandAnswer([*lines, f"{person} : {end}."], {**data, "tests": shown.tests, "erased": done})


def purge_guests(database: Database, settings: Settings, arguments: Namespace) -> CommandAnswer:
    """Erase guests without work; without `--yes`, only count them."""
    personal = _personal_data_service(database, settings)
    before = utc_now() - timedelta(days=arguments.days)
    count = personal.erase_idle_guests(before) if arguments.yes else personal.count_idle_guests(before)
    if arguments.yes:
        journal.record_action_in_own_transaction(database, AuditAction.guests_purged, after={"accounts": count})
    done = "effacé" if arguments.yes else "à effacer, avec --yes"
    many = "effacés" if arguments.yes else done
    kind = count_with_noun(count, f"invité sans travail {done}", f"invités sans travail {many}")
    return CommandAnswer(
        [f"{kind}, d’il y a plus de {count_with_noun(arguments.days, 'jour')}."],
        {"guests": count, "erased": arguments.yes},
    )


def requeue_submission(database: Database, settings: Settings, arguments: Namespace) -> CommandAnswer:
    # Nobody is told: an idle worker finds it within a second, and where NATS carries the work the server calls for it.
    submissions = SubmissionService(settings, TableQueue(NullNotifier()))
    found = requeuing.requeue_for_grading(database, submissions, failed=arguments.failed, names=arguments.submissions)
    journal.record_action_in_own_transaction(database, AuditAction.submissions_requeued, after={"attempts": len(found)})
    line = f"{count_with_noun(len(found), 'essai remis', 'essais remis')} dans la file de correction."
    return CommandAnswer([*(f"  {name}" for name in found), line], {"requeued": found})


def _personal_data_service(database: Database, settings: Settings) -> PersonalDataService:
    return PersonalDataService(database, settings, Course({}, ()))
