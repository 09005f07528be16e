"""Assignment and grade services of a platform (LTI AGS 2.0): its line items, and the scores that are posted to them.

One line item stands for one assignment in one course: it is looked for by `resourceId` before one is made, so that an
answer that was lost makes no second column.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from datetime import datetime
from typing import Any
from urllib.parse import urljoin, urlsplit, urlunsplit

from server.federation.errors import OutgoingError
from server.federation.lti.access_tokens import LINE_ITEM_SCOPE, SCORE_SCOPE, AccessTokenCache
from server.federation.lti.launch import is_platform_url
from server.federation.lti.schemas import lti_settings
from server.federation.models import IdentityProvider
from server.federation.outgoing import HttpAnswer, with_query

LINE_ITEM_TYPE = "application/vnd.ims.lis.v2.lineitem+json"
LINE_ITEMS_TYPE = "application/vnd.ims.lis.v2.lineitemcontainer+json"
SCORE_TYPE = "application/vnd.ims.lis.v1.score+json"
FULL_POINTS = 20.0
MAX_PAGES, PAGE_SIZE, MAX_LABEL = 20, 100, 200
TAG = "balise"
NO_ITEM = "la plateforme n’a pas rendu la colonne qu’elle devait créer"
OTHER_SITE = "la plateforme donne une adresse d’un autre site"
_NEXT = re.compile(r'<([^<>]{1,2000})>\s*;\s*rel="?next"?', re.IGNORECASE)


@dataclass(frozen=True)
class Score:
    """A mark to post: `points` out of 20, as of `at`, which is later than that of any score posted before."""

    subject: str
    points: float
    at: datetime

    def document(self) -> Mapping[str, Any]:
        """Return the score as a platform takes it for a final mark: any other progress would erase it in Moodle."""
        return {
            "userId": self.subject,
            "scoreGiven": self.points,
            "scoreMaximum": FULL_POINTS,
            "activityProgress": "Completed",
            "gradingProgress": "FullyGraded",
            "timestamp": self.at.isoformat(timespec="milliseconds"),
        }


class GradeServices:
    """The services of one platform. Methods block, and raise OutgoingError."""

    def __init__(self, tokens: AccessTokenCache, provider: IdentityProvider) -> None:
        self._tokens, self._provider = tokens, provider
        self._settings = lti_settings(provider)

    def find_or_create_line_item(self, line_items_url: str, resource_id: str, label: str) -> str:
        """Return the address of the line item of a resource."""
        found = self._find_line_item(line_items_url, resource_id)
        if found:
            return found
        item = {"label": label[:MAX_LABEL], "scoreMaximum": FULL_POINTS, "resourceId": resource_id, "tag": TAG}
        answer = self._request("POST", line_items_url, LINE_ITEM_SCOPE, content=item, kind=LINE_ITEM_TYPE)
        return self._line_item_url(answer.json())

    def _find_line_item(self, line_items_url: str, resource_id: str) -> str:
        asked = with_query(line_items_url, {"resource_id": resource_id, "limit": str(PAGE_SIZE)})
        for item in self._fetch_line_items(asked):
            if item.get("resourceId") == resource_id:
                return self._line_item_url(item)
        return ""

    def _fetch_line_items(self, address: str) -> Iterator[Mapping[str, Any]]:
        """Yield the items of all pages; platforms need not know the filter."""
        for _ in range(MAX_PAGES):
            answer = self._request("GET", address, LINE_ITEM_SCOPE, accept=LINE_ITEMS_TYPE)
            document = answer.json()
            yield from (item for item in document if isinstance(item, dict)) if isinstance(document, list) else ()
            address = next_page_url(answer, address)
            if not address:
                return
            self._require_platform_url(address)

    def _line_item_url(self, item: Any) -> str:
        address = item.get("id") if isinstance(item, dict) else None
        if not isinstance(address, str):
            raise OutgoingError(NO_ITEM)
        self._require_platform_url(address)
        return address

    def _require_platform_url(self, address: str) -> None:
        if not is_platform_url(address, self._provider, self._settings):
            raise OutgoingError(OTHER_SITE)

    def post_score(self, line_item_url: str, score: Score) -> None:
        """Post a score; `/scores` goes before the query of the line item's address."""
        self._request(
            "POST", append_to_url_path(line_item_url, "scores"), SCORE_SCOPE, content=score.document(), kind=SCORE_TYPE
        )

    def _request(
        self, method: str, address: str, scope: str, *, content: Any = None, kind: str = "", accept: str = ""
    ) -> HttpAnswer:
        """Ask with an access token."""
        self._require_platform_url(address)
        return self._tokens.request(
            self._provider,
            [scope],
            method,
            address,
            headers={"Content-Type": kind} if kind else None,
            content=b"" if content is None else json.dumps(content).encode(),
            accept=accept or "application/json",
        )


def append_to_url_path(address: str, name: str) -> str:
    """Return the address of a part: its name goes at the end of the path, before the query."""
    parts = urlsplit(address)
    return urlunsplit(parts._replace(path=f"{parts.path.rstrip('/')}/{name}"))


def next_page_url(answer: HttpAnswer, address: str) -> str:
    """Return the address of the next page (RFC 8288), or an empty text."""
    found = _NEXT.search(answer.headers.get("link", ""))
    return urljoin(address, found[1]) if found else ""
