"""What of a board was drawn lately. Most of its page is the same for all who look at it until something is sent, and is
found by all that it is drawn from; what a time alone changes (who is stuck, how many attempts of late) is among that.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable
from typing import Any

from markupsafe import Markup

from server.base.caches import Lately
from server.board.schemas import Insights
from server.desk.board import insight_views as views
from server.desk.board.schemas import BesideView, WorkView
from server.desk.board.shown import ShownBoard
from server.web import school_time
from server.web.rendering import environment

MOST_KNOWN = 64  # boards, by what they were found from
KEPT_CHARACTERS = 8_000_000  # of HTML: thirty boards of 35 students and 26 exercises

_KEPT: Lately[Hashable, Markup] = Lately(KEPT_CHARACTERS, size=len)
_KNOWN: Lately[Hashable, Markup] = Lately(MOST_KNOWN)


def work(shown: ShownBoard, asked: Hashable, view: Callable[[], WorkView]) -> Markup:
    """`view` of a board as it is `asked` for. What a board shows is all in its version, but for the course's words."""
    key = ("work", shown.course, shown.href, shown.board.version, asked)
    return _KEPT.get(key) or _KEPT.put(key, Markup(_macros().work(view())))


def beside(shown: ShownBoard, insights: Insights, *, may_regrade: bool) -> Markup:
    """Names of students are the board's; times are told on the school's clock. What was found of the same attempts is
    known by their name (`Insights.made`): to compare all of it would take longer than the rest of the page."""
    of_all = (shown.course, shown.href, tuple(one.name for one in shown.students), may_regrade, school_time.zone().key)
    known = (of_all, insights.made, insights.unnamed, insights.lesson[:1], insights.days[:1])
    drawn = _KNOWN.get(known)
    if drawn is None:
        key = ("beside", of_all, tuple(one.id for one in shown.students), insights)
        drawn = _KEPT.get(key) or _KEPT.put(
            key, Markup(_macros().beside(_beside(shown, insights, may_regrade=may_regrade)))
        )
        _KNOWN.put(known, drawn)
    return drawn


def _beside(shown: ShownBoard, insights: Insights, *, may_regrade: bool) -> BesideView:
    return BesideView(
        unnamed=views.unnamed(shown, insights.unnamed),
        helped=views.helped(shown, insights.helped),
        helped_hidden=sum(one.share is None for one in insights.helped),
        hints=views.hints(shown, insights.hints),
        items=views.items(shown, insights.items, may_regrade=may_regrade),
        charts=views.charts(insights),
    )


def _macros() -> Any:
    return environment().get_template("classes/board_kept.html").module
