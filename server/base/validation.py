"""Validation of what a request, a setting or a course's file holds, with reasons in French."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any
from uuid import UUID

from pydantic import BaseModel, ConfigDict, GetCoreSchemaHandler, model_validator
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

from server.base.errors import Invalid, NotFound, TooLarge

REASONS = {
    "missing": "valeur manquante",
    "extra_forbidden": "nom inconnu",
    "nothing_sent": "valeur manquante : « code », ou « answers » pour un exercice sans code",
    "string_type": "un texte est attendu",
    "string_too_short": "ne peut être vide",
    "string_pattern_mismatch": "ce nom ne convient pas",
    "bool_type": "vrai ou faux est attendu",
    "bool_parsing": "vrai ou faux est attendu",
    "int_type": "un nombre entier est attendu",
    "int_parsing": "un nombre entier est attendu",
    "int_parsing_size": "ce nombre est trop grand",
    "int_from_float": "un nombre entier est attendu",
    "float_type": "un nombre est attendu",
    "float_parsing": "un nombre est attendu",
    "finite_number": "un nombre fini est attendu",
    "greater_than": "il faut plus de {gt}",
    "greater_than_equal": "il faut au moins {ge}",
    "less_than": "il faut moins de {lt}",
    "less_than_equal": "il faut au plus {le}",
    "list_type": "une liste est attendue",
    "dict_type": "une table est attendue",
    "model_type": "une table est attendue",
    "too_short": "il en faut au moins {min_length}",
    "too_long": "il en faut au plus {max_length}",
    "literal_error": "valeur inconnue",
    "enum": "valeur inconnue",
    "path_type": "un chemin est attendu",
    "no_address": "« {address} » n’est ni une adresse IP ni un réseau",
    "no_moment": "une date ISO 8601 avec son décalage est attendue, comme « 2026-03-23T18:00:00+01:00 »",
    "no_identity": "un identifiant est attendu",
    "no_path": "« {path} » n’est pas un chemin, comme « /balise »",
    "no_zone": "« {name} » n’est pas un fuseau horaire, comme « Europe/Paris »",
    "json_invalid": "JSON mal formé",
    "model_attributes_type": "un objet est attendu",
    "too_many_names": "pas plus de {most} noms sont attendus",
}


def french_reason(error: Mapping[str, Any]) -> str:
    """Return what is wrong in French, to follow the name of the field. `error` is one of `ValidationError.errors()`."""
    bounds = {name: _format_in_french(value) for name, value in error.get("ctx", {}).items()}
    return REASONS.get(error["type"], "valeur refusée").format(**bounds)


def _format_in_french(value: object) -> str:
    return f"{value:.12g}".replace(".", ",") if isinstance(value, int | float) else str(value)


NO_BREAK = "\u00a0"
UNITS = ((1 << 30, "Gio"), (1 << 20, "Mio"), (1 << 10, "Kio"))


def format_size(count: float) -> str:
    """Write a number of bytes in French: « 64 Kio », « 1,5 Mio », « 1 octet »."""
    for unit, name in UNITS:
        if count >= unit:
            return f"{count / unit:.2f}".rstrip("0").rstrip(".").replace(".", ",") + NO_BREAK + name
    return f"{count:.0f}{NO_BREAK}octet{'s' if count >= 2 else ''}"


#: Names of an object: the refusal of each unknown one takes time and room.
MAX_NAMES = 100


class RequestBody(BaseModel):
    """The JSON body of a request: unknown names are refused, and hundreds of names as a whole."""

    model_config = ConfigDict(extra="forbid")

    @model_validator(mode="before")
    @classmethod
    def _bound_names(cls, value: Any) -> Any:
        if isinstance(value, dict) and len(value) > MAX_NAMES:
            raise PydanticCustomError("too_many_names", "at most {most} names are expected", {"most": MAX_NAMES})
        return value


@dataclass(frozen=True)
class TruncateTo:
    """In the annotation of a text parameter: characters beyond the first `max_length` are ignored."""

    max_length: int

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_after_validator_function(self._cut, handler(source))

    def _cut(self, text: str) -> str:
        return text[: self.max_length]


def parse_uuid(text: UUID | str, message: str) -> UUID:
    """Parse a UUID from an address or a request. Raise NotFound with this sentence where the text is none."""
    try:
        return text if isinstance(text, UUID) else UUID(text)
    except ValueError as error:
        raise NotFound(message) from error


def encode_bounded(text: str, max_bytes: int, subject: str = "Le code") -> bytes:
    """Encode as UTF-8. Raise Invalid for lone surrogates, TooLarge above `max_bytes`.

    `subject` begins the sentence of the error, in the singular.
    """
    try:
        source = text.encode()
    except UnicodeEncodeError as error:
        raise Invalid(f"{subject} contient un caractère qui n’existe pas en Unicode.") from error
    if len(source) > max_bytes:
        raise TooLarge(
            f"{subject} dépasse de {format_size(len(source) - max_bytes)} la limite de {format_size(max_bytes)}."
        )
    return source
