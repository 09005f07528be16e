"""Pages that are put together from what was compressed once and what is compressed each time."""

from __future__ import annotations

import gzip
import zlib

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from markupsafe import Markup

from server.base import root_path
from server.web import packing

TEXT = st.text(max_size=60) | st.text(max_size=3).map(lambda text: text * 9000)


@settings(max_examples=25)
@given(before=TEXT, long=TEXT, after=TEXT, changing=st.booleans())
def test_what_is_unpacked_is_the_page(before: str, long: str, after: str, changing: bool) -> None:
    whole = (before + long + after).encode()
    page = packing.page(f"{before}{packing.PLACE}{after}", long, changing=changing)
    reader = zlib.decompressobj(16 + zlib.MAX_WBITS)
    assert reader.decompress(page.packed) == whole, "as a browser reads it: one member, whose checksum is right"
    assert (reader.eof, reader.unused_data) == (True, b"")
    assert page.plain == whole
    alone = packing.page(whole.decode(), "elsewhere")
    assert (alone.plain, gzip.decompress(alone.packed)) == (whole, whole), "nothing comes where it has no place"


def test_a_tag_is_of_all_that_is_sent() -> None:
    place = packing.PLACE
    pages = [packing.page(html, long) for html, long in ((f"a{place}b", "x"), (f"a{place}b", "y"), (f"a{place}c", "x"))]
    pages += [packing.page(html, "x") for html in (f"d{place}b", "ab", "axb")]
    assert len({page.tag for page in pages}) == len(pages)
    assert packing.page(f"a{place}b", "x").tag == pages[0].tag


def test_addresses_go_out_under_the_path_of_the_service(monkeypatch: pytest.MonkeyPatch) -> None:
    long, place = Markup('<a href="/l20">é</a>'), packing.PLACE
    for path in ("", "/balise"):
        monkeypatch.setattr(root_path, "_roots", [path])
        page = packing.page(f'<p data-steps="/x">{place}', long)
        written = f'<p data-steps="{path}/x"><a href="{path}/l20">é</a>'
        assert (page.plain.decode(), gzip.decompress(page.packed).decode()) == (written, written)


def test_nobody_can_write_where_the_long_part_comes() -> None:
    place = str(packing.PLACE)
    assert len(place) > 32, "it cannot be guessed"
    assert place not in Markup("<p>%s</p>") % place
