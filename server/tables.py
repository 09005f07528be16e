"""Every table, so that the metadata is whole for whoever needs it whole (comparing with the migrations, tests)."""

from server.assignments import models as assignments
from server.audit import models as audit
from server.behaviour import models as behaviour
from server.calendars import models as calendars
from server.classes import models as classes
from server.comments import models as comments
from server.database.base import Base
from server.federation import models as federation
from server.gradebook import models as gradebook
from server.health import models as health
from server.identity import models as identity
from server.lesson import models as lesson
from server.limits import models as limits
from server.mails import models as mails
from server.marks import models as marks
from server.personal import models as personal
from server.polls import models as polls
from server.queue import models as queue
from server.recall import models as recall
from server.regrades import models as regrades
from server.studio import models as studio
from server.submissions import models as submissions
from server.warmup import models as warmup

TABLES = (
    identity.Account,
    identity.FederatedIdentity,
    identity.BrowserSession,
    identity.ApiToken,
    identity.PasswordLink,
    identity.Invitation,
    personal.ErasureRequest,
    limits.TokenBucket,
    classes.SchoolClass,
    classes.Membership,
    audit.AuditEvent,
    assignments.Assignment,
    assignments.AssignedExercise,
    assignments.Exemption,
    assignments.Sitting,
    assignments.SavedWork,
    queue.Job,
    submissions.Submission,
    submissions.Variant,
    gradebook.Grading,
    gradebook.Standing,
    gradebook.SolutionOpening,
    gradebook.ClassOpening,
    comments.Thread,
    comments.ThreadReader,
    comments.Message,
    comments.Phrase,
    comments.Note,
    comments.NoteReader,
    marks.Override,
    marks.StateDecision,
    marks.MarkingPolicy,
    marks.ManualColumn,
    marks.ManualMark,
    marks.Rubric,
    marks.RubricMarking,
    polls.PollAnswer,
    recall.RecallAnswer,
    recall.ReaderChoice,
    regrades.Regrade,
    regrades.RegradeItem,
    behaviour.BehaviourGroup,
    behaviour.Fingerprint,
    behaviour.BehaviourName,
    lesson.LiveLesson,
    lesson.LessonVisit,
    warmup.WarmUp,
    calendars.CalendarAddress,
    mails.MailSubscription,
    mails.MailDelivery,
    federation.IdentityProvider,
    federation.ProviderActivity,
    federation.RegistrationLink,
    federation.PendingSignIn,
    federation.ProviderContext,
    federation.ContextTeacher,
    federation.WaitingStudent,
    federation.LineItem,
    federation.MarkDelivery,
    federation.SigningKey,
    studio.AuthoredExercise,
    studio.ExerciseVersion,
    health.EventCount,
)
metadata = Base.metadata
TABLE_NAMES = frozenset(metadata.tables)
