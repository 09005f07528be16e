"""Contexts of the templates of a class: every page receives one of these types, and nothing else."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime

from server.assignments.feedback import SittingStage
from server.course import Exercise


@dataclass(frozen=True)
class ClassTab:
    """A link to a page of the class; `here`: the current page belongs to it."""

    label: str
    href: str
    here: bool


@dataclass(frozen=True)
class ClassHead:
    """The head of every page of a class, with the actions that the reader may use. `tabs` are for its staff,
    and so is `guide`, the address of the chapter about the page."""

    id: str
    name: str
    href: str
    module: str
    module_href: str
    archived: bool
    may_keep_list: bool
    may_set_up: bool
    tabs: tuple[ClassTab, ...]
    guide: str


@dataclass(frozen=True)
class JoinCodeView:
    """The join code as it is read aloud, its address, the address as a QR code (SVG), and its expiry."""

    code: str
    address: str
    svg: str
    until: datetime


@dataclass(frozen=True)
class OwnMembership:
    """The reader's own membership."""

    role: str
    pending: bool
    groups: tuple[str, ...]
    may_leave: bool


@dataclass(frozen=True)
class SittingExercise:
    """An exercise of a test: the number of submissions, and the time of the last saved draft.

    `failed` counts submissions that an internal error left ungraded; `runs`: the last file is not known to stop.
    """

    exercise: Exercise
    sent: int
    failed: int
    runs: bool
    saved: datetime | None


@dataclass(frozen=True)
class SittingPage:
    """A test as its student sees it.

    `ends`: the end of the sitting; before it, the end if it began now. `begin_by`: the last time to begin. `late`: what
    beginning now costs, or has cost. `now` is the server's time. `extra`: the student has extra time. `handed_in`: by
    the student; otherwise time ended it.
    """

    head: ClassHead
    title: str
    stage: SittingStage
    opens: datetime
    closes: datetime | None
    begin_by: datetime | None
    late: str
    minutes: str
    extra: bool
    now: datetime
    ends: datetime | None
    handed_in: bool
    exercises: tuple[SittingExercise, ...]
    action: str


@dataclass(frozen=True)
class ReleaseView:
    """The release of a test's results, with the numbers of sittings begun and still running.

    `opens` is None once somebody may have begun: until then there is nothing to release. `effects` says in one line
    each what a release now does to whom, and `version` is the tag of these effects. `copies` are those that may be
    reopened, by account and name.
    """

    action: str
    opens: datetime | None
    released: datetime | None
    begun: int
    sitting: int
    effects: tuple[str, ...]
    version: str
    may_withdraw: bool
    copies: tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class JoinFormValues:
    """The name that a visitor or a guest has entered, and why it is refused."""

    given: str
    family: str
    problem: str
