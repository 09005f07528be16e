"""From classes and their members to what the templates show."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from datetime import datetime
from functools import lru_cache, partial
from urllib.parse import urlencode

from markupsafe import Markup
from sqlalchemy.orm import Session

from server.assignments import editing
from server.classes import repository
from server.classes.codes import format_code
from server.classes.importing import ImportPlan
from server.classes.models import ClassRole, Membership, SchoolClass, Status
from server.classes.schemas import Member
from server.classes.service import PasswordSlip, valid_code
from server.comments import repository as comments
from server.course import Course, Module
from server.desk.schemas import (
    ChangeRow,
    ClassesPage,
    ClassHead,
    ClassRow,
    CodeView,
    EditionChoice,
    ImportPage,
    JoinPage,
    MemberRow,
    PeoplePage,
    SettingsPage,
    SlipsPage,
    SlipView,
    StaffRow,
)
from server.desk.tabs import tabs
from server.identity.models import Account
from server.rights import service as rights
from server.rights.models import Right
from server.rights.service import ClassAccess
from server.web import editions
from server.web.news import news_views
from server.web.words import iso_moment, short_moment

ROLES = {ClassRole.student: "élève", ClassRole.assistant: "assistant", ClassRole.teacher: "enseignant"}
ADDED, JOINS = "compte à créer", "a déjà un compte ici"
BACK = {Status.left: "revient dans la classe", Status.pending: "est admis", Status.active: "fiche complétée"}
LEAVES = "n’est pas dans la liste : sort de la classe, son travail est gardé"


def href_of(school_class: SchoolClass) -> str:
    return f"/classes/{school_class.id}"


def regrade_href(class_href: str, exercise: str) -> str:
    """Where the attempts of a class at an exercise are graded again."""
    return f"{class_href}/recalculs?{urlencode({'exercice': exercise})}"


def module_name(course: Course, slug: str) -> str:
    """A class may outlive its module on this server."""
    module = course.modules.get(slug)
    return f"Module {module.label}" if module else slug


def classes_page(db: Session, course: Course, account: Account | None) -> ClassesPage:
    seats = [] if account is None else repository.load_visible_classes(db, account)
    counts = repository.count_students(db, [school_class.id for school_class, _ in seats])
    taught = [school_class.id for school_class, seat in seats if _is_staff(seat)]
    asking = comments.count_open_questions_by_class(db, taught) if taught else {}
    rows = [(one, seat, _row(course, one, seat, *counts[one.id], asking.get(one.id, 0))) for one, seat in seats]
    return ClassesPage(
        news=news_views([] if account is None else comments.load_unread_threads(db, account.id), course),
        taught=tuple(row for one, seat, row in rows if one.archived_at is None and _is_staff(seat)),
        attended=tuple(row for one, seat, row in rows if one.archived_at is None and not _is_staff(seat)),
        archived=tuple(row for one, _, row in rows if one.archived_at is not None),
        may_create=account is not None and Right.create_class in rights.server_rights(account),
        modules=tuple((module.slug, f"{module.label} — {module.title}") for module in course.latest),
    )


def _is_staff(seat: Membership | None) -> bool:
    """Without a seat it is an administrator who looks."""
    return seat is None or seat.is_staff


def _row(
    course: Course, school_class: SchoolClass, seat: Membership | None, students: int, waiting: int, asking: int
) -> ClassRow:
    return ClassRow(
        href=href_of(school_class),
        name=school_class.name,
        module=module_name(course, school_class.module),
        role="administrateur" if seat is None else ROLES[ClassRole(seat.role)],
        pending=seat is not None and seat.status == Status.pending,
        students=students,
        waiting=waiting if _is_staff(seat) else 0,
        asking=asking,
    )


def head(course: Course, place: ClassAccess, here: str = "") -> ClassHead:
    """`here` is the path, within the class, of the tab that the page belongs to."""
    school_class = place.school_class
    return ClassHead(
        id=str(school_class.id),
        name=school_class.name,
        href=href_of(school_class),
        module=module_name(course, school_class.module),
        module_href=f"/{school_class.module}" if school_class.module in course.modules else "",
        archived=school_class.archived_at is not None,
        may_keep_list=place.has(Right.manage_roster) and school_class.archived_at is None,
        may_set_up=place.has(Right.configure_class),
        may_see_code=place.has(Right.see_code),
        tabs=tabs(href_of(school_class), place.has, here),
    )


def code_view(school_class: SchoolClass, base: str) -> CodeView | None:
    """`base` is the address of the service, without a slash at its end."""
    code, until = valid_code(school_class), school_class.join_code_until
    if code is None or until is None:
        return None
    address = f"{base}/rejoindre/{code}"
    return CodeView(format_code(code), address, _qr_of_class(address), iso_moment(until), short_moment(until))


@lru_cache(maxsize=128)
def _qr_of_class(address: str) -> str:
    """It stands beside the list of the students; links of one person are not kept."""
    return qr(address)


def qr(address: str) -> str:
    """The address as a QR code: dark on light in both themes, or phones do not read it."""
    import segno

    picture = segno.make(address, error="m", micro=False)
    return Markup(picture.svg_inline(border=4, dark="#000", light="#fff", omitsize=True, svgclass="qr", lineclass=None))


def people_page(db: Session, course: Course, place: ClassAccess, account: Account, base: str, group: str) -> PeoplePage:
    """`group`, where it is not empty, keeps the students of this group alone."""
    school_class = place.school_class
    everyone = repository.load_members(db, school_class.id)
    students = [one for one in everyone if one.role is ClassRole.student]
    active = [one for one in students if one.status is Status.active]
    labels = group_counts(one.groups for one in active)
    return PeoplePage(
        head=head(course, place, "/eleves"),
        staff=staff_rows(everyone, place, account),
        code=code_view(school_class, base) if place.has(Right.see_code) else None,
        may_hand_passwords=place.has(Right.hand_out_passwords) and school_class.archived_at is None,
        students=member_rows(one for one in active if not group or group in one.groups),
        total=len(active),
        waiting=member_rows(one for one in students if one.status is Status.pending),
        left=member_rows(one for one in students if one.status is Status.left),
        groups=tuple(labels.items()),
        group=group if group in labels else "",
        without_password=sum(_without_password(one) for one in active),
    )


def group_counts(groups: Iterable[Iterable[str]]) -> dict[str, int]:
    """How many students have each label, of the labels of each student; in their order."""
    counts = Counter(label for labels in groups for label in labels)
    return dict(sorted(counts.items(), key=lambda one: one[0].casefold()))


def staff_rows(everyone: Sequence[Member], place: ClassAccess, account: Account) -> tuple[StaffRow, ...]:
    staff = [one for one in everyone if one.membership.is_staff and one.status is Status.active]
    teachers = sum(one.role is ClassRole.teacher for one in staff)
    knows = place.has(Right.see_students)
    return tuple(
        StaffRow(
            id=str(one.id),
            name=one.name,
            login=one.account.login or "" if knows else "",
            role=ROLES[one.role],
            removable=place.has(Right.configure_class) and (one.role is not ClassRole.teacher or teachers > 1),
        )
        for one in staff
    )


def member_rows(members: Iterable[Member]) -> tuple[MemberRow, ...]:
    return tuple(
        MemberRow(
            id=str(one.id),
            name=one.name,
            login=one.account.login or "",
            groups=one.groups,
            joined=iso_moment(one.membership.joined_at),
            joined_text=short_moment(one.membership.joined_at),
            seen=_when(one.membership.last_seen_at, iso_moment),
            seen_text=_when(one.membership.last_seen_at, short_moment),
            guest=one.account.is_guest,
            without_password=_without_password(one),
        )
        for one in members
    )


def _when(when: datetime | None, written: Callable[[datetime], str]) -> str:
    return "" if when is None else written(when)


def _without_password(member: Member) -> bool:
    return member.membership.created_by_list and member.account.password_hash is None


def settings_page(db: Session, course: Course, place: ClassAccess, account: Account, base: str) -> SettingsPage:
    school_class = place.school_class
    staff = staff_rows(repository.load_staff(db, school_class.id), place, account)
    return SettingsPage(
        head=head(course, place, "/reglages"),
        approval=school_class.approval,
        staff=staff,
        code=code_view(school_class, base),
        editions=tuple(
            _choice(db, course, school_class, one) for one in editions.later_editions(course, school_class.module)
        ),
    )


def _choice(db: Session, course: Course, school_class: SchoolClass, edition: Module) -> EditionChoice:
    there = partial(editions.exercise_in_edition, course, module=edition.slug)
    left = () if edition.slug == school_class.module else editing.uncopied_exercises(db, school_class, there)
    return EditionChoice(
        slug=edition.slug,
        title=f"{edition.label} — {edition.title}",
        without=tuple(f"{_title(course, exercise)}, du devoir « {title} »" for title, exercise in left),
    )


def _title(course: Course, exercise: str) -> str:
    served = course.exercises.get(exercise)
    return f"« {served.title} »" if served else exercise


def import_page(course: Course, place: ClassAccess, plan: ImportPlan, text: str) -> ImportPage:
    added = [ChangeRow(str(line.line), line.name, line.login or line.email, ADDED) for line in plan.added]
    added += [ChangeRow(str(line.line), line.name, account.login or "", JOINS) for line, account in plan.joining]
    return ImportPage(
        head=head(course, place, "/eleves"),
        added=tuple(sorted(added, key=lambda row: int(row.line))),
        updated=tuple(
            ChangeRow(str(line.line), line.name, member.account.login or "", BACK[member.status])
            for line, member in plan.updated
        ),
        unchanged=len(plan.unchanged),
        left=tuple(ChangeRow("", member.name, member.account.login or "", LEAVES) for member in plan.left),
        rejected=tuple((one.line, one.name, one.reason) for one in plan.rejected),
        ignored=plan.ignored,
        text=text,
        digest=plan.digest,
    )


def slips_page(
    course: Course, place: ClassAccess, given: Sequence[PasswordSlip], refused: Sequence[str], days: int, base: str
) -> SlipsPage:
    links = [(slip, f"{base}/nouveau-mot-de-passe/{slip.token}") for slip in given]
    slips = tuple(SlipView(slip.name, slip.login, link, qr(link)) for slip, link in links)
    return SlipsPage(head(course, place, "/eleves"), slips, tuple(refused), days, base)


def join_page(db: Session, course: Course, school_class: SchoolClass, account: Account | None) -> JoinPage:
    everyone = repository.load_members(db, school_class.id)
    mine = next((one for one in everyone if account is not None and one.id == account.id), None)
    return JoinPage(
        code=school_class.join_code or "",
        name=school_class.name,
        module=module_name(course, school_class.module),
        teachers=tuple(one.name for one in everyone if one.role is ClassRole.teacher and one.status is Status.active),
        approval=school_class.approval,
        asks_name=account is None or account.is_guest,
        already=href_of(school_class) if mine is not None and mine.status is not Status.left else "",
    )
