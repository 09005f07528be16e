"""The answer of an action of `balise admin`: lines for people, the same as data for programs."""

import json
import sys
from argparse import Namespace
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime
from typing import Any
from uuid import UUID

from server.base.settings import Settings
from server.database import Database
from server.identity.models import Account, Role

ROLES: Mapping[str, str] = {
    Role.guest: "invité",
    Role.student: "étudiant",
    Role.teacher: "enseignant, qui crée des classes",
    Role.administrator: "administrateur, qui a toutes les classes",
}


@dataclass(frozen=True)
class CommandAnswer:
    """`data` is JSON once identities and times are text; `hint` goes to the standard error, for people alone."""

    lines: Sequence[str]
    data: Mapping[str, Any] = field(default_factory=dict)
    hint: str = ""

    def show(self, as_json: bool) -> None:
        if as_json:
            print(json.dumps(self.data, ensure_ascii=False, default=_to_json_text))
            return
        print("\n".join(self.lines))
        if self.hint:
            print(self.hint, file=sys.stderr)


Action = Callable[[Database, Settings, Namespace], CommandAnswer]


def _to_json_text(value: object) -> str:
    if isinstance(value, datetime):
        return value.isoformat()
    if isinstance(value, UUID):
        return str(value)
    raise TypeError(f"{value!r} is not told in JSON")


def account_json(account: Account) -> dict[str, Any]:
    """An account, without anything secret."""
    return {
        "id": account.id,
        "login": account.login,
        "name": account.name,
        "role": account.role,
        "created_at": account.created_at,
        "disabled_at": account.disabled_at,
    }


def account_label(account: Account) -> str:
    return f"{account.name} ({account.handle})"
