"""What the templates of the classes' pages receive: every page's context is one of these types, and nothing else."""

from __future__ import annotations

from dataclasses import dataclass

from server.web.news import NewsView


@dataclass(frozen=True)
class ClassRow:
    """A class in a list; `waiting` is how many ask to join it, `asking` how many questions wait, for its staff."""

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
    """`news` is what one was told and has not read; `modules`: slug and title of those that one may make a class of."""

    news: tuple[NewsView, ...]
    taught: tuple[ClassRow, ...]
    attended: tuple[ClassRow, ...]
    archived: tuple[ClassRow, ...]
    may_create: bool
    modules: tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class Tab:
    """A link to a page of the class; `here`: it is, or belongs to, the page that is shown."""

    label: str
    href: str
    here: bool


@dataclass(frozen=True)
class ClassHead:
    """What every page of a class begins with, and where one may go from it. `tabs` are for its staff."""

    id: str
    name: str
    href: str
    module: str
    module_href: str
    archived: bool
    may_keep_list: bool
    may_set_up: bool
    may_see_code: bool
    tabs: tuple[Tab, ...]


@dataclass(frozen=True)
class CodeView:
    """How one joins: the code as it is read aloud, the whole address, the same as a picture (SVG), and until when."""

    code: str
    address: str
    svg: str
    until: str
    until_text: str


@dataclass(frozen=True)
class MemberRow:
    """A date is empty where there is none; `guest`: bound to one browser; `handed`: their password may be remade."""

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


@dataclass(frozen=True)
class StaffRow:
    id: str
    name: str
    login: str
    role: str
    removable: bool


@dataclass(frozen=True)
class OwnSeat:
    """What somebody is in their class."""

    role: str
    pending: bool
    groups: tuple[str, ...]
    may_leave: bool


@dataclass(frozen=True)
class PeoplePage:
    """Who is in a class, as its staff see it; `students` are those of the group `group` where one is chosen."""

    head: ClassHead
    staff: tuple[StaffRow, ...]
    code: CodeView | None
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
    """An edition that a class may be copied into; `without` are exercises of its assignments that are not in it."""

    slug: str
    title: str
    without: tuple[str, ...]


@dataclass(frozen=True)
class SettingsPage:
    """`editions` are those of the class's module, from its own on."""

    head: ClassHead
    approval: bool
    staff: tuple[StaffRow, ...]
    code: CodeView | None
    editions: tuple[EditionChoice, ...]


@dataclass(frozen=True)
class ChangeRow:
    """A person whom a list adds, changes or leaves out; `note` says what happens to them."""

    line: str
    name: str
    login: str
    note: str


@dataclass(frozen=True)
class ImportPage:
    """A list before it is written. `text` is the list, `digest` says what it would change."""

    head: ClassHead
    added: tuple[ChangeRow, ...]
    updated: tuple[ChangeRow, ...]
    unchanged: int
    left: tuple[ChangeRow, ...]
    rejected: tuple[tuple[int, str, str], ...]
    ignored: tuple[str, ...]
    text: str
    digest: str

    @property
    def changes(self) -> bool:
        return bool(self.added or self.updated or self.left)


@dataclass(frozen=True)
class SlipView:
    name: str
    login: str
    link: str
    svg: str


@dataclass(frozen=True)
class SlipsPage:
    head: ClassHead
    slips: tuple[SlipView, ...]
    refused: tuple[str, ...]
    days: int
    address: str


@dataclass(frozen=True)
class SatExercise:
    """An exercise of a test: how often one has sent something, and when something was saved last (or empty).

    `failed`: how many of what was sent an error of ours has left ungraded.
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
    """A test as its student sees it. Times come as ISO and in words, empty where there are none.

    `ends`: of a sitting, its end; before it, the end if one began now. `now` is the server's time. `extra`: the time
    is longer than the others'. `handed_in`: at one's own word; else time has ended it.
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
    exercises: tuple[SatExercise, ...]
    action: str


@dataclass(frozen=True)
class ReleaseView:
    """The results of a test, to be released: how many have begun, and still sit. `released` is empty before.

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
    """The class of a code. `asks_name`: of a visitor or a guest; `already`: where who is in it already goes on."""

    code: str
    name: str
    module: str
    teachers: tuple[str, ...]
    approval: bool
    asks_name: bool
    already: str


@dataclass(frozen=True)
class JoinForm:
    """What a visitor or a guest has written of their name, and why it is refused."""

    given: str
    family: str
    problem: str
