"""Imports every table, so that the metadata is whole for whoever needs it whole (migrations, tests)."""

from server.accounts import models as accounts
from server.database.base import Base
from server.submissions import models as submissions

TABLES = (
    accounts.Account,
    accounts.BrowserSession,
    accounts.ApiToken,
    accounts.Invitation,
    accounts.Allowance,
    submissions.Submission,
    submissions.Draw,
    submissions.SolutionOpening,
)
metadata = Base.metadata
