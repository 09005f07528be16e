"""From the addresses of the service to places in an archive, relative to the page that they stand on.

Pages of an archive are opened from a folder of the reader's machine: nothing may begin at a root that is not there, and
what only the service can show leads to one page that says so.
"""

from __future__ import annotations

import html
import posixpath
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from urllib.parse import urlsplit

#: Where a link leads that needs the service.
ON_THE_SERVER = "sur-le-serveur.html"
#: Our templates and our Markdown write every address so, and escape quotes in what they show.
ADDRESS = re.compile(r'(?<=\s)(href|src|data-source|data-hands|data-action|data-answers)="(/[^"]*)"')


@dataclass(frozen=True)
class ArchiveLinkRewriter:
    """Where in the archive what has an address stands; `met` gathers the files of the front end that pages ask for."""

    static: str
    by_address: Mapping[str, str]
    met: set[str] = field(default_factory=set)

    def relative(self, page: str, place: str) -> str:
        """The html of a page that is written with addresses, for the place where it will stand."""
        return ADDRESS.sub(lambda found: self._rewrite_attribute(found[1], html.unescape(found[2]), place), page)

    def _rewrite_attribute(self, name: str, address: str, place: str) -> str:
        target = self._archive_path(address)
        return f'{name}="{html.escape(posixpath.relpath(target, posixpath.dirname(place) or "."))}"'

    def _archive_path(self, address: str) -> str:
        """Where it leads, with the place in the page."""
        if address.startswith(f"{self.static}/"):
            name = address.removeprefix(f"{self.static}/")
            self.met.add(name)
            return f"static/{name}"
        parts = urlsplit(address)
        asked = f"{parts.path}?{parts.query}" if parts.query else parts.path
        known = self.by_address.get(asked)
        if known is None:
            return ON_THE_SERVER
        return f"{known}#{parts.fragment}" if parts.fragment else known
