"""Contexts of the templates of a class: every page receives one of these types, and nothing else."""

from __future__ import annotations

from dataclasses import dataclass

from server.marks.states import ClassMarking
from server.web.news import NewsView


@dataclass(frozen=True)
class ClassListRow:
    """A class in a list; `waiting` counts join requests, `asking` open questions, for its staff."""

    href: str
    name: str
    module: str
    role: str
    pending: bool
    students: int
    waiting: int
    asking: int = 0


@dataclass(frozen=True)
class ClassesPage:
    """The list of classes; `news`: unread messages; `modules`: slug and title of those for a new class."""

    news: tuple[NewsView, ...]
    taught: tuple[ClassListRow, ...]
    attended: tuple[ClassListRow, ...]
    archived: tuple[ClassListRow, ...]
    may_create: bool
    modules: tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class ClassTab:
    """A link to a page of the class; `here`: the current page belongs to it."""

    label: str
    href: str
    here: bool


@dataclass(frozen=True)
class ClassHead:
    """The head of every page of a class, with the actions that the reader may use. `tabs` are for its staff."""

    id: str
    name: str
    href: str
    module: str
    module_href: str
    archived: bool
    may_keep_list: bool
    may_set_up: bool
    may_see_code: bool
    tabs: tuple[ClassTab, ...]


@dataclass(frozen=True)
class JoinCodeView:
    """The join code as it is read aloud, its address, the address as a QR code (SVG), and its expiry."""

    code: str
    address: str
    svg: str
    until: str
    until_text: str


@dataclass(frozen=True)
class MemberRow:
    """A member of the list. Missing dates are empty; `guest`: without a login, bound to one browser."""

    id: str
    name: str
    login: str
    groups: tuple[str, ...]
    joined: str
    joined_text: str
    seen: str
    seen_text: str
    guest: bool
    without_password: bool
    doubtful: bool


@dataclass(frozen=True)
class StaffRow:
    id: str
    name: str
    login: str
    role: str
    removable: bool


@dataclass(frozen=True)
class OwnMembership:
    """The reader's own membership."""

    role: str
    pending: bool
    groups: tuple[str, ...]
    may_leave: bool


@dataclass(frozen=True)
class PeoplePage:
    """The members of a class as its staff see them; `students` are those of the label `group` if it is chosen."""

    head: ClassHead
    staff: tuple[StaffRow, ...]
    code: JoinCodeView | None
    may_hand_passwords: bool
    students: tuple[MemberRow, ...]
    total: int
    waiting: tuple[MemberRow, ...]
    left: tuple[MemberRow, ...]
    groups: tuple[tuple[str, int], ...]
    group: str
    without_password: int


@dataclass(frozen=True)
class EditionChoice:
    """An edition into which a class may be copied; `without`: assigned exercises that it lacks."""

    slug: str
    title: str
    without: tuple[str, ...]


@dataclass(frozen=True)
class SettingsPage:
    """The settings of a class; `editions`: those of its module, from its own on; `marking`: what its means count."""

    head: ClassHead
    approval: bool
    version: str
    marking: ClassMarking
    staff: tuple[StaffRow, ...]
    code: JoinCodeView | None
    editions: tuple[EditionChoice, ...]


@dataclass(frozen=True)
class ImportChangeRow:
    """A person whom a list adds, changes or leaves out; `note` describes the change."""

    line: str
    name: str
    login: str
    note: str


@dataclass(frozen=True)
class ImportPage:
    """The preview of a list. `text` is the list, `digest` identifies its changes."""

    head: ClassHead
    added: tuple[ImportChangeRow, ...]
    updated: tuple[ImportChangeRow, ...]
    unchanged: int
    left: tuple[ImportChangeRow, ...]
    rejected: tuple[tuple[int, str, str], ...]
    ignored: tuple[str, ...]
    text: str
    digest: str

    @property
    def changes(self) -> bool:
        return bool(self.added or self.updated or self.left)


@dataclass(frozen=True)
class PasswordSlipView:
    name: str
    login: str
    link: str
    svg: str


@dataclass(frozen=True)
class SlipsPage:
    head: ClassHead
    slips: tuple[PasswordSlipView, ...]
    refused: tuple[str, ...]
    days: int
    address: str


@dataclass(frozen=True)
class SittingExercise:
    """An exercise of a test: the number of submissions, and the time of the last saved draft (or empty).

    `failed` counts submissions that an internal error left ungraded.
    """

    title: str
    href: str
    kind: str
    sent: int
    failed: int
    saved: str
    saved_text: str


@dataclass(frozen=True)
class SittingPage:
    """A test as its student sees it. Times come as ISO text and in words, empty where there are none.

    `ends`: the end of the sitting; before it, the end if it began now. `now` is the server's time. `extra`: the
    student has extra time. `handed_in`: by the student; otherwise time ended it.
    """

    head: ClassHead
    title: str
    stage: str
    opens: str
    opens_text: str
    closes: str
    closes_text: str
    minutes: str
    extra: bool
    now: str
    ends: str
    ends_text: str
    handed_in: bool
    exercises: tuple[SittingExercise, ...]
    action: str


@dataclass(frozen=True)
class ReleaseView:
    """The release of a test's results: the numbers of sittings begun and still running. `released` is empty before.

    `opens` is empty once somebody may have begun: until then there is nothing to release.
    """

    action: str
    opens: str
    opens_text: str
    released: str
    released_text: str
    begun: int
    sitting: int


@dataclass(frozen=True)
class JoinPage:
    """The class of a join code. `asks_name`: for visitors and guests; `already`: its address for current members."""

    code: str
    name: str
    module: str
    teachers: tuple[str, ...]
    approval: bool
    asks_name: bool
    already: str


@dataclass(frozen=True)
class JoinFormValues:
    """The name that a visitor or a guest has entered, and why it is refused."""

    given: str
    family: str
    problem: str
