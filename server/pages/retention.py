"""What is kept, for how long, by which setting, and by what it is removed: one table, which the page « Données
personnelles » and the administrators' pages show, and in which each table of the database stands once."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from server.assignments.editing import RESTORABLE
from server.base.settings import Settings, variable_name
from server.base.validation import format_size
from server.figures.store import MAX_STORE_BYTES
from server.identity.devices import DEVICE_DAYS
from server.identity.service import BUCKET_RETENTION
from server.mails.service import DELIVERY_DAYS, UNCONFIRMED_DAYS
from server.personal.service import GUEST_GRACE

HOURLY = "le service, toutes les heures"
AT_ONCE = "avec le compte, aussitôt qu’il est effacé"
OWNER = "tant que le compte existe"
CLASS = "tant que la classe existe"
ACCOUNT_SETTINGS = ("left_days", "silent_days")


@dataclass(frozen=True)
class RetentionRow:
    """`tables` of the database, or `places` in the folder of the data or elsewhere; `settings` by their names."""

    what: str
    kept: str
    removed: str
    settings: tuple[str, ...] = ()
    tables: tuple[str, ...] = ()
    places: tuple[str, ...] = ()

    @property
    def variables(self) -> tuple[str, ...]:
        return tuple(map(variable_name, self.settings))


def _days_text(count: float) -> str:
    return f"{count:.0f}\u00a0jour" + ("s" if count >= 2 else "")


def _hours_text(count: float) -> str:
    return f"{count:.0f}\u00a0heure" + ("s" if count >= 2 else "")


def _describe_account_retention(settings: Settings) -> str:
    rules = []
    if settings.left_days:
        whose = "élève venu d’une liste ou du système d’un établissement"
        rules.append(f"{_days_text(settings.left_days)} après sa dernière classe ({whose})")
    if settings.silent_days:
        rules.append(f"{_days_text(settings.silent_days)} sans que personne s’en serve (élève)")
    return " ; ".join([*rules, "jusqu’à ce que son titulaire le supprime"])


def _describe_guest_retention(settings: Settings) -> str:
    after = f"fin de sa session ({_days_text(settings.session_days)}), puis {_days_text(GUEST_GRACE.days)}"
    idle = f" ; sans aucun travail, {_days_text(settings.guest_days)}" if settings.guest_days else ""
    return after + idle


def list_retention_rows(settings: Settings) -> Iterator[RetentionRow]:
    """In the order of who would ask."""
    for make in _ROWS:
        yield make(settings)


_ROWS: tuple[Callable[[Settings], RetentionRow], ...] = (
    lambda settings: RetentionRow(
        "Comptes : nom, identifiant, empreinte du mot de passe",
        _describe_account_retention(settings),
        f"son titulaire, un enseignant ou l’administrateur à sa demande, « balise admin purge », ou {HOURLY}",
        ACCOUNT_SETTINGS,
        ("account",),
    ),
    lambda _: RetentionRow(
        "Identités dans le système d’un établissement : son adresse, et le numéro qu’il donne à la personne",
        OWNER,
        AT_ONCE,
        ACCOUNT_SETTINGS,
        ("federated_identity",),
    ),
    lambda _: RetentionRow(
        "Plateformes d’un établissement (Moodle, ENT…) : leurs adresses, leurs cours, ce que chacune a fait en dernier",
        "jusqu’à ce que l’administrateur les retire",
        "l’administrateur",
        (),
        ("identity_provider", "provider_activity", "provider_context", "line_item"),
    ),
    lambda _: RetentionRow(
        "Clés avec lesquelles ce service signe, et connexions commencées par une plateforme : rien de personne",
        "les clés, 105 jours ; une connexion, 10 minutes, ou 2 heures pour choisir un contenu ; une adresse "
        "d’inscription, 24 heures",
        HOURLY,
        (),
        ("signing_key", "pending_sign_in", "registration_link"),
    ),
    lambda _: RetentionRow(
        "Notes envoyées à une plateforme, et ce qu’elle a répondu ; cours qu’un enseignant y donne, "
        "classes de l’établissement dont un élève vient",
        OWNER,
        AT_ONCE,
        ACCOUNT_SETTINGS,
        ("mark_delivery", "context_teacher", "waiting_student"),
    ),
    lambda settings: RetentionRow(
        "Invités, et tout leur travail",
        _describe_guest_retention(settings),
        HOURLY,
        ("session_days", "guest_days"),
    ),
    lambda settings: RetentionRow(
        "Sessions",
        _days_text(settings.session_days),
        f"à la déconnexion, ou {HOURLY}",
        ("session_days",),
        ("browser_session",),
    ),
    lambda _: RetentionRow(
        "Navigateurs où un compte s’est connecté : empreinte d’un numéro tiré au hasard",
        f"{_days_text(DEVICE_DAYS)} après la dernière connexion, et vingt au plus par compte",
        f"le lien vers un nouveau mot de passe, ou {HOURLY}",
        (),
        ("known_device",),
    ),
    lambda settings: RetentionRow(
        "Jetons",
        f"{_days_text(settings.api_token_days)}, et jamais plus que le mot de passe avec lequel on les a créés",
        f"leur titulaire, un changement de mot de passe ou de rôle, ou {HOURLY}",
        ("api_token_days",),
        ("api_token",),
    ),
    lambda _: RetentionRow(
        "Adresse secrète d’un agenda : son empreinte, et sa date",
        "jusqu’à ce que son titulaire la remplace ou la supprime",
        f"son titulaire, ou {AT_ONCE}",
        (),
        ("calendar_address",),
    ),
    lambda _: RetentionRow(
        "Courriels de « Après la séance » : adresse donnée par l’enseignant, suite de chaque envoi",
        f"jusqu’à l’arrêt ; sans confirmation, {_days_text(UNCONFIRMED_DAYS)} ; un envoi, {_days_text(DELIVERY_DAYS)}",
        f"l’enseignant, par la page ou par le lien d’un courriel, ou {AT_ONCE}",
        ("smtp_host",),
        ("mail_subscription", "mail_delivery"),
    ),
    lambda settings: RetentionRow(
        "Liens vers un mot de passe",
        f"{_hours_text(settings.password_link_hours)} ; le premier, sur une fiche de connexion, avec son code tant "
        f"qu’il n’a pas servi, {_days_text(settings.first_password_days)} depuis que l’enseignant l’a affiché",
        f"à leur usage, avec le rôle ou le droit pour lequel ils ont été faits, ou {HOURLY}",
        ("password_link_hours", "first_password_days"),
        ("password_link",),
    ),
    lambda _: RetentionRow(
        "Invitations à ouvrir un compte d’enseignant",
        "jusqu’à leur fin ; la trace d’une invitation qui a servi reste, sans nom",
        HOURLY,
        (),
        ("invitation",),
    ),
    lambda _: RetentionRow(
        "Essais, corrections, notes, films de ce que le code a fait, réponses aux questions "
        "des séances et à ce qui revient, choix de lecture",
        OWNER,
        AT_ONCE,
        ACCOUNT_SETTINGS,
        (
            "submission",
            "grading",
            "early_verdict",
            "standing",
            "deal",
            "poll_answer",
            "recall_answer",
            "reader_choice",
            "regrade_item",
        ),
    ),
    lambda _: RetentionRow(
        "Devoirs : temps de composition, travail gardé, aménagements, binômes et équipes (ce qu’un élève effacé a "
        "envoyé pour deux reste à l’autre), notes modifiées, absences et dispenses, notes tapées par les enseignants",
        OWNER,
        AT_ONCE,
        ACCOUNT_SETTINGS,
        (
            "sitting",
            "saved_work",
            "exemption",
            "team_member",
            "team_proposal",
            "mark_override",
            "mark_decision",
            "manual_mark",
            "rubric_marking",
        ),
    ),
    lambda _: RetentionRow(
        "Séances : exercices du jour, questions pour commencer, début et fin ; élèves marqués « vu »",
        "tant que la classe existe ; les élèves vus, tant que leur compte existe",
        "avec la classe ou le compte, aussitôt qu’il est effacé",
        ACCOUNT_SETTINGS,
        ("live_lesson", "lesson_visit", "warm_up"),
    ),
    lambda _: RetentionRow(
        "Messages et mots ; phrases d’un enseignant",
        "tant que le compte de l’élève existe ; sans le nom d’un enseignant dont le compte est effacé",
        AT_ONCE,
        ACCOUNT_SETTINGS,
        ("thread", "thread_reader", "message", "phrase", "note", "note_reader"),
    ),
    lambda settings: RetentionRow(
        "Demandes d’effacement : le compte, qui l’a demandé, quand",
        f"jusqu’à la publication des contrôles où il a composé, et {_days_text(settings.erasure_days)} au plus",
        f"avec le compte, à l’annulation, ou {HOURLY}",
        ("erasure_days",),
        ("erasure_request",),
    ),
    lambda _: RetentionRow(
        "Appartenance à une classe, et dernière visite",
        OWNER,
        AT_ONCE,
        ACCOUNT_SETTINGS,
        ("membership",),
    ),
    lambda _: RetentionRow(
        "Classes, devoirs, colonnes, barèmes et règles du carnet, corrigés ouverts, recorrections",
        CLASS,
        "avec la classe, dans la base de données",
        (),
        (
            "school_class",
            "assignment",
            "assigned_exercise",
            "manual_column",
            "rubric",
            "marking_policy",
            "class_opening",
            "solution_opening",
            "regrade",
        ),
    ),
    lambda _: RetentionRow(
        "Devoirs supprimés, qui se rétablissent, avec leurs aménagements et leurs copies",
        _days_text(RESTORABLE.days),
        HOURLY,
        (),
    ),
    lambda _: RetentionRow(
        "Exercices écrits par un enseignant, et leurs versions publiées",
        "tant que le compte de l’enseignant existe ; publiés, sans son nom, tant que le service existe : des élèves "
        "les ont faits",
        "leur auteur tant qu’ils ne sont pas publiés, ou le service, toutes les heures, après l’effacement du compte",
        (),
        ("authored_exercise", "exercise_version"),
    ),
    lambda _: RetentionRow(
        "Façon de lire les colonnes d’une liste, que l’enseignant a dite : sans nom d’élève",
        "tant que le compte de l’enseignant existe ; les vingt dernières",
        AT_ONCE,
        (),
        ("list_reading",),
    ),
    lambda _: RetentionRow(
        "Journal d’une classe : qui a changé une note, une date, un droit",
        f"{CLASS} ; sans le nom ni les motifs de qui est effacé",
        "avec la classe, dans la base de données",
        (),
        ("audit_event",),
    ),
    lambda _: RetentionRow(
        "Groupes d’essais qui se trompent de même, sans nom, et la ligne où chacun se trompe",
        "tant qu’un essai s’y trouve, ou qu’un enseignant les a nommés",
        HOURLY,
        (),
        ("behaviour_group", "fingerprint", "behaviour_name"),
    ),
    lambda _: RetentionRow(
        "Travaux en file, avec l’adresse d’où vient l’envoi",
        "jusqu’au verdict, ou à trois échecs",
        "le correcteur",
        (),
        ("job",),
    ),
    lambda _: RetentionRow(
        "Billets de NATS, entre machines : des numéros de travaux, sans nom ni code",
        "jusqu’à ce que le travail soit pris",
        "NATS",
        ("nats_url",),
        (),
        ("flux de NATS",),
    ),
    lambda _: RetentionRow(
        "Compteurs de demandes, par compte ou par adresse",
        f"{_days_text(BUCKET_RETENTION.days)} après la dernière, et une heure au plus",
        HOURLY,
        (),
        ("allowance",),
    ),
    lambda _: RetentionRow(
        "Décompte de ce que font les correcteurs d’autres machines, qui ne nomme personne",
        "sans fin",
        "personne",
        (),
        ("count",),
    ),
    lambda _: RetentionRow(
        "Figures et animations dessinées, sans nom ni compte",
        f"tant qu’il y a de la place : {format_size(MAX_STORE_BYTES)}, les moins regardées partent d’abord",
        "le service",
        (),
        (),
        ("figures/",),
    ),
    lambda _: RetentionRow(
        "Archives des modules, ce qui a été lu du cours : rien de personne",
        "jusqu’à la version suivante du cours",
        "le service",
        (),
        (),
        ("archives/", "course.json"),
    ),
    lambda _: RetentionRow(
        "Visiteurs des cinq dernières minutes, en mémoire, sans nom ni adresse",
        "5\u00a0minutes",
        "le service",
        (),
        (),
        ("mémoire du serveur",),
    ),
    lambda _: RetentionRow(
        "Journaux et demandes : ni code, ni adresse, ni nom",
        "ce que règle la machine qui les reçoit",
        "la machine (journald, logrotate…)",
        ("log_format",),
        (),
        ("sortie d’erreur",),
    ),
    lambda _: RetentionRow(
        "Sauvegardes, et copies d’avant une mise à jour : tout ce qui était dans la base ce jour-là",
        "jusqu’à ce qu’elles soient remplacées",
        "l’administrateur, là où il les met",
        ("upgrade_backup_dir",),
        (),
        ("fichiers de « balise backup »", "fichiers « .avant-… »"),
    ),
)
