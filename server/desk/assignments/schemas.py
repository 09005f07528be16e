"""What the templates of assignments receive: every page's context is one of these types, and nothing else."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from server.assignments.models import Assignment
from server.classes.schemas import Member
from server.desk.assignments.late_line import LateLine
from server.desk.schemas import ClassHead, OwnMembership, ReleaseView
from server.marks.own import VisibleMarks
from server.marks.schemas import ActiveDecision


@dataclass(frozen=True)
class FormattedDate:
    """A date as ISO text, and on the school's clock; both empty for none."""

    iso: str = ""
    text: str = ""


@dataclass(frozen=True)
class StageView:
    """Where an assignment stands: a name for the style, a sign, words."""

    kind: str
    sign: str
    words: str


@dataclass(frozen=True)
class AssignmentRow:
    """An assignment as its staff see it in the list, given to so many `students`; `finished` of them have solved all of
    it, at any time.

    `begun` students have begun it, where it is a test: what they had solved before does not count there.
    """

    href: str
    title: str
    mode: str
    is_test: bool
    stage: StageView
    opens: FormattedDate
    due: FormattedDate
    closes: FormattedDate
    exercises: int
    exemptions: int
    finished: int
    begun: int
    students: int
    groups: tuple[str, ...] = ()


@dataclass(frozen=True)
class AssignmentsPage:
    head: ClassHead
    rows: tuple[AssignmentRow, ...]
    may_keep: bool
    zone: str
    papers: tuple[PaperLink, ...]
    removed: Sequence[Assignment]


@dataclass(frozen=True)
class PaperLink:
    """A paper of the course, and the form that gives it as a test."""

    href: str
    title: str


@dataclass(frozen=True)
class WeightedExerciseRow:
    title: str
    href: str
    weight: str


@dataclass(frozen=True)
class AssignmentPage:
    """One assignment, as its staff see it. `facts` are its rules by name; `release` is of a test, for its teachers.

    `rubric`: the title of the column in which it is marked by hand, empty without one.
    """

    head: ClassHead
    row: AssignmentRow
    exercises: tuple[WeightedExerciseRow, ...]
    facts: tuple[tuple[str, str], ...]
    line: LateLine
    may_keep: bool
    may_compare: bool
    release: ReleaseView | None
    warnings: Sequence[str]
    may_mark: bool
    rubric: str
    teams: TeamsSummary | None = None


@dataclass(frozen=True)
class TeamsSummary:
    """The teams of an assignment: « binômes » or « équipes », how many there are, and the students without one."""

    word: str
    count: int
    alone: int


@dataclass(frozen=True)
class ExerciseOption:
    """An exercise that one may give. `after` names the lesson that it begins to follow, where it is another."""

    id: str
    title: str
    checked: bool
    weight: str
    after: str = ""


@dataclass(frozen=True)
class AssignmentValues:
    """What the fields of the form hold, as text."""

    title: str = ""
    opens: str = ""
    due: str = ""
    closes: str = ""
    late: str = "accept"
    per_day: str = ""
    weight: str = "1"
    counts: str = "best"
    hints: str = "usual"
    diagnosis: str = "usual"
    solution: str = "usual"
    mode: str = "practice"
    duration: str = ""
    weights: Mapping[str, str] = field(default_factory=dict)
    audience: str = ""
    groups: tuple[str, ...] = ()
    team_size: str = "1"
    teams_by_students: str = ""

    @property
    def chosen_groups(self) -> tuple[str, ...]:
        """The groups to which it is given: none for the whole class, whatever is ticked."""
        return self.groups if self.audience else ()


@dataclass(frozen=True)
class AssignmentFormPage:
    """`problems` are by the field's name; `line` is drawn where the form is good enough to draw it.

    `counts` and `shown` are what one may choose, each with its words; `groups`, with their numbers of students.
    """

    head: ClassHead
    action: str
    back: str
    is_new: bool
    version: str
    values: AssignmentValues
    choices: tuple[ExerciseOption, ...]
    problems: Mapping[str, str]
    line: LateLine | None
    zone: str
    counts: tuple[tuple[str, str], ...]
    shown: tuple[tuple[str, str], ...]
    team_sizes: tuple[tuple[str, str], ...]
    groups: Mapping[str, int]


@dataclass(frozen=True)
class OwnExercise:
    """`kind` is for the style; `mark` in words, empty where there is nothing to say yet."""

    title: str
    href: str
    kind: str
    sign: str
    words: str
    late: str


@dataclass(frozen=True)
class OwnTestStatus:
    """Where somebody stands in a test: what the way to its page says, `href` empty for who only watches."""

    href: str
    link: str
    running: bool
    ends: FormattedDate


@dataclass(frozen=True)
class RubricNotice:
    """The column in which an assignment is marked by hand."""

    title: str
    published: bool


@dataclass(frozen=True)
class OwnTeam:
    """With whom a student hands in; `may_choose`: the students form the teams. `href` is empty for who only watches."""

    word: str
    partners: tuple[str, ...]
    may_choose: bool
    href: str


@dataclass(frozen=True)
class OwnAssignment:
    """An assignment with the rules in force for who looks; `exercises` is None while they are not told.

    `mark`: in words, once it is over, or decided, and told; `decision`: of a teacher, about the whole assignment.
    """

    id: str
    title: str
    is_test: bool
    stage: StageView
    opens: FormattedDate
    due: FormattedDate
    closes: FormattedDate
    late: str
    excused: bool
    duration: str
    why_href: str
    exercises: tuple[OwnExercise, ...] | None
    done: int
    differs: bool
    test: OwnTestStatus | None = None
    mark: str = ""
    decision: ActiveDecision | None = None
    rubric: RubricNotice | None = None
    team: OwnTeam | None = None
    copy_href: str = ""


@dataclass(frozen=True)
class NextStep:
    """What to do next: a test that is open, or an exercise of the assignment that is due first."""

    href: str
    title: str
    assignment: str
    begun: bool
    is_test: bool = False


@dataclass(frozen=True)
class OwnLessonExercise:
    """An exercise of the day; `solved` as far as the student may know it."""

    title: str
    href: str
    solved: bool


@dataclass(frozen=True)
class OwnLesson:
    """The exercises of the day; `challenge` and `helps` for a student who has solved them all."""

    exercises: tuple[OwnLessonExercise, ...]
    finished: bool
    helps: bool
    challenge: OwnLessonExercise | None


@dataclass(frozen=True)
class OwnWarmUp:
    """The questions of today with which the lesson begins; `left` of `total` are still to be answered."""

    href: str
    total: int
    left: int


@dataclass(frozen=True)
class OwnClassPage:
    """A class as who learns there sees it; `watched` names them where their teacher looks with their eyes.

    `done`: what is open still, with nothing left to do there; `marks`: None for somebody who is not in yet.
    """

    head: ClassHead
    seat: OwnMembership
    staff: list[Member]
    current: tuple[OwnAssignment, ...]
    done: tuple[OwnAssignment, ...]
    upcoming: tuple[OwnAssignment, ...]
    past: tuple[OwnAssignment, ...]
    next: NextStep | None
    average: str
    marks: VisibleMarks | None
    zone: str
    lesson: OwnLesson | None = None
    warm_up: OwnWarmUp | None = None
    watched: str = ""
