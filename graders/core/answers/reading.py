"""Parsing of a submission's bytes into answers, and their canonical serialisation."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

MAX_FILE_BYTES = 64 * 1024
MAX_SHOWN = 120


class UnreadableAnswersError(Exception):
    """The file is not one JSON object; `args[0]` says why, in French."""


def read_answers(source: bytes) -> dict[str, Any]:
    """Return the answers by question. Raises UnreadableAnswersError.

    Numbers beyond every float become infinities, which are rejected where an answer is read.
    """
    if len(source) > MAX_FILE_BYTES:
        raise UnreadableAnswersError(f"Ce fichier de réponses dépasse {MAX_FILE_BYTES // 1024} Kio.")
    try:
        answers = json.loads(
            source.decode("utf-8-sig"), object_pairs_hook=_object_without_duplicates, parse_int=_parse_integer
        )
    except UnicodeDecodeError as error:
        raise UnreadableAnswersError("Ce fichier de réponses n'est pas en UTF-8.") from error
    except json.JSONDecodeError as error:
        position = f"ligne {error.lineno}, colonne {error.colno}"
        raise UnreadableAnswersError(f"Ce fichier n'est pas du JSON bien formé ({position}).") from error
    except RecursionError as error:
        raise UnreadableAnswersError("Ce fichier de réponses est trop imbriqué.") from error
    if not isinstance(answers, dict):
        raise UnreadableAnswersError("On attend un objet JSON : un nom de question, puis la réponse, entre accolades.")
    return answers


def _object_without_duplicates(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    members = dict(pairs)
    if len(members) != len(pairs):
        raise UnreadableAnswersError("Une même question porte deux réponses dans ce fichier.")
    return members


def _parse_integer(digits: str) -> float:
    return int(digits) if len(digits) < 300 else float("-inf" if digits.startswith("-") else "inf")


def canonical_json(answers: Mapping[str, Any]) -> str:
    """Return the canonical JSON of answers. Raises ValueError (RecursionError) for values nested too deep."""
    return json.dumps(answers, ensure_ascii=False, sort_keys=True, separators=(",", ":"))


def display_text(value: Any) -> str:
    """Return a short text of an answer, safe to store and to print."""
    try:
        text = value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)
    except RecursionError:
        text = "…"
    text = "".join(c if c.isprintable() else "·" for c in text[: MAX_SHOWN + 1])
    return text if len(text) <= MAX_SHOWN else text[: MAX_SHOWN - 1] + "…"


def is_blank(value: Any) -> bool:
    """Whether nothing was answered: no value, an empty text, nothing ticked."""
    return value is None or value == [] or (isinstance(value, str) and not value.strip())
