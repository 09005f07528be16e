"""One change of a mark, a date or a right in a class."""

from collections.abc import Mapping
from datetime import datetime
from enum import StrEnum
from typing import Any
from uuid import UUID, uuid4

from sqlalchemy import JSON, ForeignKey, Index, String, Text
from sqlalchemy.orm import Mapped, mapped_column

from server.database.base import Base, UtcDateTime, utc_now

ABOUT_LENGTH = 300


class AuditAction(StrEnum):
    """Kinds of changes, as stored; `ACTION_LABELS` are shown by the page and the exports."""

    assignment_made = "assignment_made"
    assignment_changed = "assignment_changed"
    assignment_deleted = "assignment_deleted"
    assignment_restored = "assignment_restored"
    exemption_made = "exemption_made"
    exemption_revoked = "exemption_revoked"
    team_formed = "team_formed"
    team_ended = "team_ended"
    feedback_released = "feedback_released"
    release_withdrawn = "release_withdrawn"
    copy_reopened = "copy_reopened"
    staff_changed = "staff_changed"
    student_removed = "student_removed"
    student_admitted = "student_admitted"
    student_confirmed = "student_confirmed"
    groups_changed = "groups_changed"
    erasure_requested = "erasure_requested"
    erasure_cancelled = "erasure_cancelled"
    student_erased = "student_erased"
    mark_overridden = "mark_overridden"
    override_withdrawn = "override_withdrawn"
    state_decided = "state_decided"
    decision_withdrawn = "decision_withdrawn"
    marking_changed = "marking_changed"
    column_made = "column_made"
    column_changed = "column_changed"
    column_deleted = "column_deleted"
    column_restored = "column_restored"
    column_mark_changed = "column_mark_changed"
    regrade_applied = "regrade_applied"
    regrade_undone = "regrade_undone"
    name_given = "name_given"
    name_withdrawn = "name_withdrawn"
    lesson_started = "lesson_started"
    lesson_changed = "lesson_changed"
    lesson_ended = "lesson_ended"
    platform_added = "platform_added"
    platform_changed = "platform_changed"
    platform_paused = "platform_paused"
    platform_resumed = "platform_resumed"
    platform_removed = "platform_removed"
    platform_link_made = "platform_link_made"
    course_tied = "course_tied"
    course_untied = "course_untied"
    marks_resent = "marks_resent"
    account_created = "account_created"
    invitation_made = "invitation_made"
    password_link_made = "password_link_made"
    role_changed = "role_changed"
    account_disabled = "account_disabled"
    account_enabled = "account_enabled"
    access_revoked = "access_revoked"
    accounts_purged = "accounts_purged"
    guests_purged = "guests_purged"
    submissions_requeued = "submissions_requeued"
    standings_rebuilt = "standings_rebuilt"
    backup_restored = "backup_restored"
    database_moved = "database_moved"


ACTION_LABELS: Mapping[AuditAction, str] = {
    AuditAction.assignment_made: "devoir créé",
    AuditAction.assignment_changed: "devoir modifié",
    AuditAction.assignment_deleted: "devoir supprimé",
    AuditAction.assignment_restored: "devoir rétabli",
    AuditAction.exemption_made: "aménagement accordé",
    AuditAction.exemption_revoked: "aménagement retiré",
    AuditAction.team_formed: "binôme ou équipe d’un devoir formés",
    AuditAction.team_ended: "binôme ou équipe d’un devoir défaits",
    AuditAction.feedback_released: "résultats d’un contrôle publiés",
    AuditAction.release_withdrawn: "publication d’un contrôle reprise",
    AuditAction.copy_reopened: "copie rouverte",
    AuditAction.staff_changed: "équipe modifiée",
    AuditAction.student_removed: "élève sorti de la classe",
    AuditAction.student_admitted: "élève admis dans la classe",
    AuditAction.erasure_requested: "effacement d’un élève demandé",
    AuditAction.erasure_cancelled: "effacement d’un élève annulé",
    AuditAction.student_erased: "élève effacé",
    AuditAction.student_confirmed: "élève confirmé, qui a le nom d’un autre",
    AuditAction.groups_changed: "groupes d’un élève modifiés",
    AuditAction.mark_overridden: "note modifiée",
    AuditAction.override_withdrawn: "note modifiée retirée",
    AuditAction.state_decided: "absence, dispense ou zéro",
    AuditAction.decision_withdrawn: "absence, dispense ou zéro retirés",
    AuditAction.marking_changed: "règles de la moyenne modifiées",
    AuditAction.column_made: "colonne créée",
    AuditAction.column_changed: "colonne modifiée",
    AuditAction.column_deleted: "colonne supprimée",
    AuditAction.column_restored: "colonne rétablie",
    AuditAction.column_mark_changed: "note d’une colonne modifiée",
    AuditAction.regrade_applied: "recorrection appliquée",
    AuditAction.regrade_undone: "recorrection annulée",
    AuditAction.name_given: "erreur nommée",
    AuditAction.name_withdrawn: "nom d’erreur retiré",
    AuditAction.lesson_started: "séance commencée",
    AuditAction.lesson_changed: "séance modifiée",
    AuditAction.lesson_ended: "séance terminée",
    AuditAction.platform_added: "plateforme ajoutée",
    AuditAction.platform_changed: "plateforme modifiée",
    AuditAction.platform_paused: "plateforme suspendue",
    AuditAction.platform_resumed: "plateforme rouverte",
    AuditAction.platform_removed: "plateforme retirée",
    AuditAction.platform_link_made: "adresse d’inscription d’une plateforme créée",
    AuditAction.course_tied: "cours d’une plateforme lié",
    AuditAction.course_untied: "cours d’une plateforme délié",
    AuditAction.marks_resent: "notes envoyées de nouveau à une plateforme",
    AuditAction.account_created: "compte créé",
    AuditAction.invitation_made: "lien d’invitation créé",
    AuditAction.password_link_made: "lien vers un mot de passe créé",
    AuditAction.role_changed: "rôle d’un compte changé",
    AuditAction.account_disabled: "compte suspendu",
    AuditAction.account_enabled: "compte rétabli",
    AuditAction.access_revoked: "sessions ou jetons révoqués",
    AuditAction.accounts_purged: "comptes périmés effacés",
    AuditAction.guests_purged: "invités sans travail effacés",
    AuditAction.submissions_requeued: "essais remis à corriger",
    AuditAction.standings_rebuilt: "bilans refaits",
    AuditAction.backup_restored: "sauvegarde restaurée",
    AuditAction.database_moved: "données copiées d’une autre base",
}

#: Actions on one student, or on all students with a label.
STUDENT_ACTIONS = frozenset(
    {
        AuditAction.exemption_made,
        AuditAction.exemption_revoked,
        AuditAction.team_formed,
        AuditAction.team_ended,
        AuditAction.copy_reopened,
        AuditAction.student_removed,
        AuditAction.student_admitted,
        AuditAction.student_confirmed,
        AuditAction.groups_changed,
        AuditAction.erasure_requested,
        AuditAction.erasure_cancelled,
        AuditAction.student_erased,
        AuditAction.mark_overridden,
        AuditAction.override_withdrawn,
        AuditAction.state_decided,
        AuditAction.decision_withdrawn,
        AuditAction.column_mark_changed,
    }
)


#: Actions of administrators: of no class.
SERVER_ACTIONS = frozenset(
    {
        AuditAction.platform_added,
        AuditAction.platform_changed,
        AuditAction.platform_paused,
        AuditAction.platform_resumed,
        AuditAction.platform_removed,
        AuditAction.platform_link_made,
        AuditAction.account_created,
        AuditAction.invitation_made,
        AuditAction.password_link_made,
        AuditAction.role_changed,
        AuditAction.account_disabled,
        AuditAction.account_enabled,
        AuditAction.access_revoked,
        AuditAction.accounts_purged,
        AuditAction.guests_purged,
        AuditAction.submissions_requeued,
        AuditAction.standings_rebuilt,
        AuditAction.backup_restored,
        AuditAction.database_moved,
    }
)


class AuditEvent(Base):
    """An append-only record of a change. It outlives the accounts that it names; the reason is erased with the student.

    `about` names the changed thing (an assignment, an exercise); `before` and `after` are plain values by field. An
    event without a class is of the server: an administrator's.
    """

    __tablename__ = "audit_event"

    id: Mapped[UUID] = mapped_column(primary_key=True, default=uuid4)
    class_id: Mapped[UUID | None] = mapped_column(ForeignKey("school_class.id", ondelete="CASCADE"))
    at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)
    by: Mapped[UUID | None] = mapped_column(ForeignKey("account.id", ondelete="SET NULL"), index=True)
    what: Mapped[str] = mapped_column(String(32))
    student: Mapped[UUID | None] = mapped_column(ForeignKey("account.id", ondelete="SET NULL"), index=True)
    about: Mapped[str] = mapped_column(String(ABOUT_LENGTH), default="")
    before: Mapped[dict[str, Any]] = mapped_column(JSON, default=dict)
    after: Mapped[dict[str, Any]] = mapped_column(JSON, default=dict)
    reason: Mapped[str] = mapped_column(Text, default="")

    __table_args__ = (Index("ix_audit_event_class_id_at", "class_id", "at"),)
