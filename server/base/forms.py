"""Decoding of large forms at the speed of C: the parser of forms unescapes in Python, on the loop that serves all.

A form of half a megabyte of `%E9` would hold it for a tenth of a second. It goes on as one of several parts, whose
values nobody has to unescape.
"""

from __future__ import annotations

import re
import secrets
from binascii import a2b_qp

from python_multipart.multipart import parse_options_header
from starlette.types import Scope

from server.base.errors import Invalid, TooLarge

URL_ENCODED, MULTIPART = b"application/x-www-form-urlencoded", b"multipart/form-data"
#: Bytes of a form above which it is decoded here; above the second, its parts could be too long for their parser.
LARGE, MAX_BYTES = 4096, 1 << 20
#: Bounds of every form: three fields for each student of the longest list, and some more. A part takes its parser
#: longer than a field: a form of more fields than `MAX_PARTS` stays as it is, and one that comes in parts has no more.
MAX_FIELDS, MAX_FILES, MAX_PARTS = 10_000, 10, 1000
TOO_MANY_FIELDS = (
    f"Ce formulaire a plus de {MAX_FIELDS:_} champs, ou de {MAX_FILES} fichiers : rien n’en a été lu. Envoyez-le en "
    "plusieurs fois."
).replace("_", "\u202f")
TOO_MANY_PARTS = (
    f"Ce formulaire a plus de {MAX_PARTS:_} parties : rien n’en a été lu. Envoyez-le en plusieurs fois."
).replace("_", "\u202f")
UNREADABLE = "Ce formulaire n’est pas lisible : rechargez la page et recommencez."
_MALFORMED = re.compile(rb"%(?![0-9A-Fa-f]{2})")
_NAME = re.compile(rb"[ !#-\[\]-~]*")


def decode_large_form(scope: Scope, body: bytes) -> tuple[Scope, bytes]:
    """Return the request of a large form as one of several parts; any other as it is. Raises Invalid or TooLarge, this
    for one of too many parts, too."""
    kind = next((value for name, value in scope["headers"] if name == b"content-type"), b"")
    if len(body) > LARGE and kind.lower().startswith(MULTIPART):
        _require_few_parts(kind, body)
    if not LARGE < len(body) <= MAX_BYTES or kind.partition(b";")[0].strip().lower() != URL_ENCODED:
        return scope, body
    fields = body.count(b"&") + 1
    if fields > MAX_FIELDS:
        raise TooLarge(TOO_MANY_FIELDS)
    if fields > MAX_PARTS:
        return scope, body
    boundary = secrets.token_hex(16).encode()
    parts = [_form_part(boundary, *pair.partition(b"=")) for pair in body.split(b"&") if pair]
    whole = b"".join((*parts, b"--", boundary, b"--\r\n"))
    changed = {b"content-type": b"multipart/form-data; boundary=" + boundary, b"content-length": b"%d" % len(whole)}
    headers = [(name, changed.get(name, value)) for name, value in scope["headers"]]
    return {**scope, "headers": headers}, whole


def _require_few_parts(kind: bytes, body: bytes) -> None:
    """Raise TooLarge; the parser counts parts as it reads them, a tenth of a second for thousands."""
    boundary = parse_options_header(kind)[1].get(b"boundary")
    if boundary and body.count(b"--" + boundary) > MAX_PARTS:
        raise TooLarge(TOO_MANY_PARTS)


def _form_part(boundary: bytes, name: bytes, _equals: bytes, value: bytes) -> bytes:
    known_as = unquote_plus_bytes(name)
    if not _NAME.fullmatch(known_as):
        raise Invalid(UNREADABLE)
    head = b'--%s\r\nContent-Disposition: form-data; name="%s"\r\n\r\n' % (boundary, known_as)
    return head + unquote_plus_bytes(value).decode("utf-8", "replace").encode() + b"\r\n"


def unquote_plus_bytes(text: bytes) -> bytes:
    """Return what `urllib.parse.unquote_plus` does, as bytes: by the decoder of quoted-printable, which is in C."""
    text = text.replace(b"+", b" ")
    if b"%" not in text:
        return text
    text = _MALFORMED.sub(b"%25", text)
    return a2b_qp(text.replace(b"=", b"%3D").replace(b"%", b"="))
