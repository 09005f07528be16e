"""Builds the contexts of the pages of classes and members."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from datetime import timedelta
from functools import lru_cache, partial
from typing import Any
from urllib.parse import urlencode
from uuid import UUID

from markupsafe import Markup
from sqlalchemy.orm import Session

from server.assignments import editing, sitting_repository
from server.assignments import repository as assignments
from server.audit.models import AuditAction
from server.audit.repository import load_entries
from server.audit.schemas import AuditFilter
from server.classes import namesakes, repository
from server.classes.codes import format_join_code
from server.classes.folding import normalise_name
from server.classes.importing import ImportPlan
from server.classes.models import ClassRole, Membership, SchoolClass, Status
from server.classes.schemas import Member
from server.classes.service import unexpired_join_code
from server.classes.slips import PasswordSlip
from server.comments import repository as comments
from server.comments.service import load_unread_threads
from server.course import Course
from server.course.editions import parse_edition
from server.database import utc_now
from server.desk.guide.chapters import chapter_href
from server.desk.schemas import ClassHead, JoinCodeView
from server.desk.tabs import visible_tabs
from server.federation import waiting
from server.identity.models import Account
from server.identity.secrets import format_link_code as format_slip_code
from server.marks.repository import load_marking_rules
from server.rights import service as rights
from server.rights.models import Right
from server.rights.service import ClassAccess
from server.text.lines import normalise_line
from server.web import editions
from server.web.form_version import form_version_tag
from server.web.words import count_with_noun, format_short_time, join_names_with_limit

STUDENTS_A_PAGE = 18
NEW_STAFF_NOTICE, MAX_STAFF_NOTICES = timedelta(days=7), 5
NEW_STAFF = "{name} enseigne ou assiste ici depuis le {when}, à la demande de {by}."
ROLES = {ClassRole.student: "élève", ClassRole.assistant: "assistant", ClassRole.teacher: "enseignant"}
NEW_ACCOUNT_NOTE, EXISTING_ACCOUNT_NOTE = "compte à créer", "a déjà un compte ici"
UPDATE_NOTES = {Status.left: "revient dans la classe", Status.pending: "est admis", Status.active: "fiche complétée"}
CODE_LEAVING_NOTE = "entré par le code : aucune liste ne le nomme ; sort de la classe, son travail est gardé"
LEAVING_NOTE = "n’est pas dans la liste : sort de la classe, son travail est gardé"


def class_href(school_class: SchoolClass) -> str:
    return f"/classes/{school_class.id}"


def regrade_href(class_href: str, exercise: str) -> str:
    """Return the address of the regrade form of a class for an exercise."""
    return f"{class_href}/recalculs?{urlencode({'exercice': exercise})}"


def module_name(course: Course, slug: str) -> str:
    """Return the label of a module, or its slug where the server no longer has it."""
    module = course.modules.get(slug)
    return f"Module {module.label}" if module else slug


def build_classes_page(db: Session, course: Course, account: Account | None, module: str = "") -> dict[str, Any]:
    """Build the page of somebody's classes; `module`: the slug chosen in the form of a new class, if any."""
    seats = [] if account is None else repository.load_visible_classes(db, account)
    counts = repository.count_students(db, [school_class.id for school_class, _ in seats])
    taught = [school_class.id for school_class, seat in seats if _is_staff(seat)]
    asking = comments.count_open_questions_by_class(db, taught) if taught else {}
    rows: list[dict[str, Any]] = []
    for school_class, seat in seats:
        students, asking_in = counts[school_class.id]
        rows.append(
            {
                "listed": school_class,
                "href": class_href(school_class),
                "module": module_name(course, school_class.module),
                "role": "administrateur" if seat is None else ROLES[ClassRole(seat.role)],
                "is_staff": _is_staff(seat),
                "pending": seat is not None and seat.status == Status.pending,
                "students": students,
                "waiting": asking_in if _is_staff(seat) else 0,
                "asking": asking.get(school_class.id, 0),
            }
        )
    courses = [] if account is None else waiting.load_taught_contexts(db, account.id)
    return {
        "school_courses": [(course, students) for course, _, students in courses if course.class_id is None],
        "news": [] if account is None else load_unread_threads(db, account),
        "taught": [row for row in rows if row["listed"].archived_at is None and row["is_staff"]],
        "attended": [row for row in rows if row["listed"].archived_at is None and not row["is_staff"]],
        "archived": [row for row in rows if row["listed"].archived_at is not None],
        "may_create": account is not None and Right.create_class in rights.server_rights(account),
        "may_write": account is not None and Right.write_exercises in rights.server_rights(account),
        "modules": course.latest,
        "chosen_module": module
        or _propose_module(course, [school_class for school_class, seat in seats if _is_staff(seat)]),
    }


def _propose_module(course: Course, taught: Sequence[SchoolClass]) -> str:
    """Return the slug of the module to propose for a new class: that of most of the classes taught, archived or not
    (its last edition), else the one with the most exercises."""
    latest = {parse_edition(module.slug).family: module for module in course.latest}
    families = Counter(parse_edition(school_class.module).family for school_class in taught)
    known = [family for family, _ in families.most_common() if family in latest]
    if known:
        return latest[known[0]].slug
    return max(course.latest, key=lambda module: len(module.exercises)).slug if course.latest else ""


def _is_staff(seat: Membership | None) -> bool:
    """Whether the reader is staff; an administrator has no membership."""
    return seat is None or seat.is_staff


def class_head(course: Course, access: ClassAccess, here: str = "") -> ClassHead:
    """Build the head of a page; `here` is the path of its tab within the class."""
    school_class = access.school_class
    return ClassHead(
        id=str(school_class.id),
        name=school_class.name,
        href=class_href(school_class),
        module=module_name(course, school_class.module),
        module_href=f"/{school_class.module}" if school_class.module in course.modules else "",
        archived=school_class.archived_at is not None,
        may_keep_list=access.has(Right.manage_roster) and school_class.archived_at is None,
        may_set_up=access.has(Right.configure_class),
        tabs=visible_tabs(class_href(school_class), access.has, here),
        guide=chapter_href(here),
    )


def join_code_view(school_class: SchoolClass, base: str) -> JoinCodeView | None:
    """Build the view of a valid join code; `base` is the address of the service, without a final slash."""
    code, until = unexpired_join_code(school_class), school_class.join_code_until
    if code is None or until is None:
        return None
    address = f"{base}/rejoindre/{code}"
    return JoinCodeView(format_join_code(code), address, _cached_class_qr_code(address), until)


@lru_cache(maxsize=128)
def _cached_class_qr_code(address: str) -> str:
    """Cache the QR code of the class page; links of single persons are not cached."""
    return render_qr_code(address)


def render_qr_code(address: str) -> str:
    """Render the address as a QR code, dark on light in both themes so that phones can read it."""
    import segno

    picture = segno.make(address, error="m", micro=False)
    return Markup(picture.svg_inline(border=4, dark="#000", light="#fff", omitsize=True, svgclass="qr", lineclass=None))


def build_people_page(
    db: Session, course: Course, access: ClassAccess, base: str, group: str, search: str = "", number: int = 1
) -> dict[str, Any]:
    """Build page `number` (from 1) of the members. A non-empty `group` filters students by label, and `search` by what
    their name, login or groups contain, accents and case aside."""
    school_class = access.school_class
    everyone = repository.load_members(db, school_class.id)
    students = [member for member in everyone if member.role is ClassRole.student]
    active = [member for member in students if member.status is Status.active]
    labels = count_students_by_label(member.groups for member in active)
    words = normalise_name(search).split()
    matching = [
        member for member in active if (not group or group in member.groups) and (not words or _matches(member, words))
    ]
    first = (number - 1) * STUDENTS_A_PAGE
    return {
        "head": class_head(course, access, "/eleves"),
        "staff": active_staff(everyone),
        "new_staff": new_staff_notices(db, school_class.id),
        "code": join_code_view(school_class, base) if access.has(Right.see_code) else None,
        "may_hand_passwords": access.has(Right.hand_out_passwords) and school_class.archived_at is None,
        "students": matching[first : first + STUDENTS_A_PAGE],
        "matching": len(matching),
        "search": search,
        "number": number,
        "more": first + STUDENTS_A_PAGE < len(matching),
        "first": first + 1,
        "doubtful": namesakes.find_unconfirmed_namesakes(everyone),
        "total": len(active),
        "waiting": [member for member in students if member.status is Status.pending],
        "left": [member for member in students if member.status is Status.left],
        "groups": labels,
        "group": group if group in labels else "",
        "without_password": sum(member.awaits_first_password for member in active),
    }


def _matches(member: Member, words: Sequence[str]) -> bool:
    known = normalise_name(" ".join((member.name, member.account.login or "", *member.groups)))
    return all(word in known for word in words)


def new_staff_notices(db: Session, class_id: UUID) -> tuple[str, ...]:
    """Return who has come to teach in the last days, and by whom: the team is told on the page of the class."""
    since = utc_now() - NEW_STAFF_NOTICE
    entries = load_entries(db, class_id, AuditFilter(what=AuditAction.staff_changed), limit=MAX_STAFF_NOTICES)
    return tuple(
        NEW_STAFF.format(
            name=entry.student.name,
            when=format_short_time(entry.at),
            by=entry.by.name if entry.by else "un compte effacé",
        )
        for entry in entries
        if entry.at >= since and entry.after.get("role") and entry.student is not None
    )


def count_students_by_label(groups: Iterable[Iterable[str]]) -> dict[str, int]:
    """Count the students of each label, sorted by label."""
    counts = Counter(label for labels in groups for label in labels)
    return dict(sorted(counts.items(), key=lambda count: count[0].casefold()))


def active_staff(everyone: Sequence[Member]) -> list[Member]:
    return [member for member in everyone if member.membership.is_staff and member.status is Status.active]


def settings_texts(name: str, approval: bool) -> Mapping[str, str]:
    """Return the settings of a class as their form shows them, by label."""
    return {"Nom de la classe": normalise_line(name), "Valider chaque inscription": "oui" if approval else "non"}


def build_settings_page(db: Session, course: Course, access: ClassAccess, base: str) -> dict[str, Any]:
    """Build the settings; `editions`: those of its module from its own on, with the assigned exercises each lacks."""
    school_class = access.school_class
    choices = []
    for edition in editions.list_editions_for_class_copy(course, school_class.module):
        is_in_edition = partial(editions.find_exercise_in_edition, course, module=edition.slug)
        same = edition.slug == school_class.module
        choices.append((edition, () if same else editing.find_uncopied_exercises(db, school_class, is_in_edition)))
    return {
        "head": class_head(course, access, "/reglages"),
        "approval": school_class.approval,
        "version": form_version_tag(settings_texts(school_class.name, school_class.approval)),
        "marking": load_marking_rules(db, school_class.id),
        "staff": active_staff(repository.load_staff(db, school_class.id)),
        "roles": ROLES,
        "code": join_code_view(school_class, base),
        "editions": choices,
        "archiving": archiving_effects(db, school_class),
    }


def archiving_effects(db: Session, school_class: SchoolClass) -> str:
    """Return in one line whom archiving the class now would touch; empty where nothing goes on in it."""
    now = utc_now()
    given = assignments.load_class_assignments(db, school_class.id)
    opened = [
        assignment.title
        for assignment in given
        if assignment.opens_at <= now and (assignment.closes_at is None or now < assignment.closes_at)
    ]
    sittings = sitting_repository.load_sittings(db, [assignment.id for assignment in given])
    sitting_now = {account_id for (_, account_id), sitting in sittings.items() if sitting.handed_in_at is None}
    names = [
        student.name for student in repository.load_active_students(db, school_class.id) if student.id in sitting_now
    ]
    lines = []
    if names:
        lines.append(
            f"{count_with_noun(len(names), 'élève compose', 'élèves composent')} en ce moment : "
            f"{join_names_with_limit(names)}."
        )
    if opened:
        lines.append(f"{count_with_noun(len(opened), 'devoir')} en cours : {join_names_with_limit(opened)}.")
    return " ".join(lines)


def build_import_page(course: Course, access: ClassAccess, plan: ImportPlan, text: str) -> dict[str, Any]:
    """Build the preview of a list; each change: line number, name, login, and what happens."""
    added = [(line.line, line.name, line.login or line.email, NEW_ACCOUNT_NOTE) for line in plan.added]
    added += [(line.line, line.name, account.handle, EXISTING_ACCOUNT_NOTE) for line, account in plan.joining]
    return {
        "head": class_head(course, access, "/eleves"),
        "plan": plan,
        "added": sorted(added),
        "updated": [
            (line.line, line.name, member.account.handle, UPDATE_NOTES[member.status]) for line, member in plan.updated
        ],
        "left": [("", member.name, member.account.handle, _leaving_note(member)) for member in plan.left],
        "others": plan.others,
        "text": text,
    }


def _leaving_note(member: Member) -> str:
    return LEAVING_NOTE if member.membership.created_by_list else CODE_LEAVING_NOTE


def build_slips_page(
    course: Course, access: ClassAccess, slips: Sequence[PasswordSlip], refused: Sequence[str], days: int, base: str
) -> dict[str, Any]:
    links = [(slip, f"{base}/nouveau-mot-de-passe/{slip.token}") for slip in slips]
    return {
        "head": class_head(course, access, "/eleves"),
        "slips": [(slip, format_slip_code(slip.token), render_qr_code(link)) for slip, link in links],
        "refused": refused,
        "days": days,
        "address": base,
    }


def build_join_page(db: Session, course: Course, school_class: SchoolClass, account: Account | None) -> dict[str, Any]:
    everyone = repository.load_members(db, school_class.id)
    own = next((member for member in everyone if account is not None and member.id == account.id), None)
    return {
        "code": school_class.join_code or "",
        "name": school_class.name,
        "module": module_name(course, school_class.module),
        "teachers": [
            member.name for member in everyone if member.role is ClassRole.teacher and member.status is Status.active
        ],
        "approval": school_class.approval,
        "asks_name": account is None or account.is_guest,
        "already": class_href(school_class) if own is not None and own.status is not Status.left else "",
    }
