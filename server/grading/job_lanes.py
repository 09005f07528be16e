"""The kinds of jobs that workers run, and the lane of each: interactive or background."""

from collections.abc import Mapping

from server.behaviour.fingerprints import FINGERPRINT
from server.queue.interfaces import BACKGROUND, INTERACTIVE
from server.regrades.service import REGRADE_JOB
from server.studio.service import TRIAL_JOB, TRYOUT_JOB
from server.submissions.service import GRADE

JOB_LANES: Mapping[str, str] = {
    GRADE: INTERACTIVE,
    REGRADE_JOB: BACKGROUND,
    FINGERPRINT: BACKGROUND,
    TRIAL_JOB: BACKGROUND,
    TRYOUT_JOB: INTERACTIVE,
}
