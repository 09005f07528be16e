"""Which passwords are refused, and why."""

from __future__ import annotations

import pytest

from server.identity import passwords
from server.identity.passwords import BLANK, SAME, TOO_COMMON, TOO_LONG, TOO_SHORT
from tests.support.service import Site

LOGIN, NAME = "ada.lovelace@example.org", "Ada Lovelace"


def why(password: str) -> str:
    return passwords.password_problem(password, login=LOGIN, name=NAME)


@pytest.mark.parametrize(
    ("password", "reason"),
    [
        ("court", TOO_SHORT),
        ("é" * 7, TOO_SHORT),
        ("x" * 1025, TOO_LONG),
        (" " * 8, BLANK),
        ("\u00a0\t" * 5, BLANK),
        (LOGIN, SAME),
        ("ADA.LOVELACE", SAME),
        ("ada lovelace", SAME),
        *(
            (word, TOO_COMMON)
            for word in ("password", "motdepasse", "azertyuiop", "12345678", "87654321", "qwertyuiop")
        ),
        *(
            (word, TOO_COMMON)
            for word in ("aaaaaaaa", "abababab", "12341234", "PassWord1!", "soleil123", "coucoucoucou")
        ),
    ],
)
def test_what_anybody_would_try_first_is_refused(password: str, reason: str) -> None:
    assert why(password) == reason


@pytest.mark.parametrize(
    "password",
    [
        "notes sur la machine",
        "tricot vert",
        "Xk3!vQ9p",
        "2024-09-01",
        "le lidar lit loin",
        "éèàçùôîû",
        "!?;:§%µ£",
        "日本語のパスワード",
    ],
)
def test_what_a_person_would_make_up_is_accepted(password: str) -> None:
    assert why(password) == ""


def test_a_common_password_opens_no_account_and_is_told_beside_its_field(site: Site) -> None:
    form = {"name": NAME, "login": LOGIN, "password": "password"}
    answer = site.client.post("/inscription", data=form)
    assert answer.status_code == 422
    assert 'id="password-probleme"' in answer.text
    assert "essaie en premier" in answer.text
