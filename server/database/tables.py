"""Imports every table, so that the metadata is whole for whoever needs it whole (migrations, tests)."""

from server.database.base import Base
from server.identity import models as accounts
from server.limits import models as limits
from server.submissions import models as submissions

TABLES = (
    accounts.Account,
    accounts.BrowserSession,
    accounts.ApiToken,
    accounts.Invitation,
    limits.Allowance,
    submissions.Submission,
    submissions.Draw,
    submissions.SolutionOpening,
)
metadata = Base.metadata
