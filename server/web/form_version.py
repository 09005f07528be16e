"""Optimistic locking of forms: a form carries the version of the values that it was drawn from.

Two people, or two tabs, may edit the same thing: the later save is refused in words, with what was saved meanwhile
beside what was typed, and one step to save all the same.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from hashlib import sha256

from starlette.datastructures import FormData

from server.identity.models import Account
from server.web.form_identity import FormRefusal, resendable_text_fields

VERSION_FIELD = "version"
VERSION_DIGITS = 16
CHANGED_MEANWHILE = (
    "{subject} a été modifié depuis que cette page est ouverte. La colonne « Enregistré » montre ce que le serveur "
    "garde en ce moment ; votre version n’est que sur cette page, tant que vous ne l’enregistrez pas."
)
SAVE_MINE = "Enregistrer ma version"

FieldTexts = Mapping[str, str]


class FormVersionChanged(FormRefusal):
    slug = "autre-version"
    title = "Modifié entre-temps"


def form_version_tag(values: FieldTexts) -> str:
    """Return the version tag of what a form shows: equal values have equal tags."""
    text = json.dumps(sorted(values.items()), ensure_ascii=False)
    return sha256(text.encode()).hexdigest()[:VERSION_DIGITS]


def require_unchanged_values(
    form: FormData, account: Account, subject: str, stored: FieldTexts, typed: FieldTexts
) -> None:
    """Raise FormVersionChanged for a form drawn from other values than the stored ones.

    `stored` and `typed` are texts by the label of their field. A form without a version is taken as it is, and so is
    one that changes nothing.
    """
    changes = [(label, text, typed.get(label, "")) for label, text in stored.items() if typed.get(label, "") != text]
    if changes:
        detail = CHANGED_MEANWHILE.format(subject=subject)
        require_form_version(form, account, form_version_tag(stored), detail, SAVE_MINE, changes)


def require_form_version(
    form: FormData,
    account: Account,
    version: str,
    detail: str,
    button: str,
    changes: Sequence[tuple[str, str, str]] = (),
) -> None:
    """Raise FormVersionChanged, with this detail and button, for a form that carries another version."""
    if form.get(VERSION_FIELD, version) == version:
        return
    replacements = {VERSION_FIELD: version}
    raise FormVersionChanged(
        detail, resendable_text_fields(form), account=account, button=button, replacements=replacements, changes=changes
    )
