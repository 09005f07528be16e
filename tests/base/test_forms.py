"""Large forms, decoded before the parser of forms: the same fields, and no work of Python for each escape."""

from __future__ import annotations

from typing import Any
from urllib.parse import unquote_plus, urlencode

import pytest
from hypothesis import given
from hypothesis import strategies as st
from starlette.requests import Request

from server.base.errors import Invalid, TooLarge
from server.base.forms import LARGE, MAX_FIELDS, MAX_PARTS, URL_ENCODED, decode_large_form, unquote_plus_bytes
from tests.support.coroutines import run_apart

PADDING = ("remplissage", "x" * LARGE)


def request(body: bytes, kind: bytes = URL_ENCODED) -> tuple[dict[str, Any], bytes]:
    headers = [(b"content-type", kind), (b"content-length", b"%d" % len(body)), (b"cookie", b"a=b")]
    return {"type": "http", "method": "POST", "headers": headers}, body


def fields(scope: Any, body: bytes) -> list[tuple[str, Any]]:
    async def receive() -> Any:
        return {"type": "http.request", "body": body, "more_body": False}

    async def parse() -> list[tuple[str, Any]]:
        async with Request(scope, receive).form() as form:
            return form.multi_items()

    return run_apart(parse())


@given(st.binary(max_size=60) | st.text("%=+&a0Fé\r\n ", max_size=40).map(str.encode))
def test_text_is_unescaped_as_urllib_does(text: bytes) -> None:
    expected = unquote_plus(text.decode("latin-1"))
    if text.isascii():
        assert unquote_plus_bytes(text).decode("utf-8", "replace") == expected


NAMES = st.sampled_from(["code", "points[1]", "l20/poses", "a b"])


@given(st.lists(st.tuples(NAMES, st.text(max_size=30)), max_size=8))
def test_a_large_form_has_the_fields_that_it_would_have_had(pairs: list[tuple[str, str]]) -> None:
    plain = request(urlencode([*pairs, PADDING]).encode())
    decoded = decode_large_form(*plain)
    assert decoded != plain
    assert fields(*decoded) == fields(*plain) == [*pairs, PADDING]
    assert dict(decoded[0]["headers"])[b"content-length"] == b"%d" % len(decoded[1])


def test_bytes_that_are_no_text_are_replaced() -> None:
    assert fields(*decode_large_form(*request(b"a=%E9%zz%&b=" + b"%E9" * LARGE))) == [
        ("a", "\ufffd%zz%"),
        ("b", "\ufffd" * LARGE),
    ]


def test_small_forms_and_other_bodies_go_on_as_they_are() -> None:
    for plain in (request(b"a=b"), request(b"x" * 9999, b"application/json"), request(b"a=b&" * 9, URL_ENCODED)):
        assert decode_large_form(*plain) == plain


@pytest.mark.parametrize("body", [b"&" * 500_000, b"a=b&" * MAX_FIELDS + b"c" * LARGE, b"a%22=" + b"x" * LARGE])
def test_a_form_of_too_many_fields_or_of_a_name_that_no_page_has_is_refused(body: bytes) -> None:
    with pytest.raises((Invalid, TooLarge)):
        decode_large_form(*request(body))


def test_a_form_of_many_fields_is_left_to_its_parser() -> None:
    """Three fields for each student of a large class: parts would take longer."""
    plain = request(b"&".join(b"n-%d=12%%2C5" % number for number in range(9000)))
    assert decode_large_form(*plain) == plain


def parts(count: int, boundary: bytes) -> bytes:
    part = b'--%s\r\nContent-Disposition: form-data; name="a"\r\n\r\n--b\r\n' % boundary
    return part * count + b"--%s--\r\n" % boundary


@pytest.mark.parametrize(
    "kind", [b"multipart/form-data; boundary=x", b'Multipart/Form-Data; charset=utf-8; boundary="x"']
)
def test_a_form_of_too_many_parts_is_refused_before_its_parser_counts_them(kind: bytes) -> None:
    with pytest.raises(TooLarge, match="1\u202f000 parties"):
        decode_large_form(*request(parts(MAX_PARTS + 1, b"x"), kind))
    assert len(fields(*decode_large_form(*request(parts(MAX_PARTS - 1, b"x"), kind)))) == MAX_PARTS - 1
