"""What a full mark comes to against the time at which it is sent, as a line and in sentences."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta

from markupsafe import Markup, escape

from server.assignments.models import LatePolicy
from server.assignments.rules import DAY, MAX_POINTS, Rules
from server.base import school_time
from server.web.words import format_long_time, format_points

WIDTH, HEIGHT = 420.0, 196.0
LEFT, RIGHT, TOP, BOTTOM = 34.0, 410.0, 14.0, 142.0
MAX_DRAWN_STEPS = 60  # beyond, steps are drawn as a slope
MARGIN_AFTER_LAST_DATE = timedelta(days=3)  # what is drawn after the last date that matters


@dataclass(frozen=True)
class LateLine:
    """A drawing (SVG), and the same in sentences."""

    svg: Markup
    sentences: tuple[str, ...]
    is_test: bool = False


@dataclass(frozen=True)
class _LineSegment:
    """From one moment to another the best possible mark goes from `left` to `right`; None: nothing counts."""

    start: datetime
    end: datetime
    left: float | None
    right: float | None


def draw_late_line(rules: Rules) -> LateLine:
    """Of the rules in force."""
    sentences = tuple(_sentences(rules))
    pieces = list(_line_segments(rules))
    return LateLine(_render_svg(rules, pieces, " ".join(sentences)), sentences, rules.is_test)


def _line_segments(rules: Rules) -> Iterator[_LineSegment]:
    opens, end = rules.opens_at, _end_of_drawing(rules)
    on_time = min(rules.due_at or end, rules.closes_at or end)
    yield _LineSegment(opens, on_time, MAX_POINTS, MAX_POINTS)
    accepted = min(rules.closes_at or end, end)
    if rules.late is LatePolicy.accept and accepted > on_time:
        yield _LineSegment(on_time, accepted, MAX_POINTS, MAX_POINTS)
    elif rules.late is LatePolicy.penalty:
        yield from _penalty_steps(rules, on_time, accepted)
    shut = on_time if rules.late is LatePolicy.refuse else accepted
    if end > shut:
        yield _LineSegment(shut, end, None, None)


def _penalty_steps(rules: Rules, due: datetime, end: datetime) -> Iterator[_LineSegment]:
    """A step for each day begun on the school's clock, down to nothing."""
    per_day = rules.late_per_day
    days = min(rules.count_days_late(end), math.ceil(MAX_POINTS / per_day))
    if days > MAX_DRAWN_STEPS:
        bottom = min(school_time.end_of_day(due, days, rules.zone), end)
        yield _LineSegment(due, bottom, MAX_POINTS, max(0.0, MAX_POINTS - days * per_day))
        days, reached = 0, bottom
    else:
        reached = due
    for day in range(1, days + 1):
        worth = max(0.0, MAX_POINTS - day * per_day)
        begin, reached = reached, min(school_time.end_of_day(due, day, rules.zone), end)
        yield _LineSegment(begin, reached, worth, worth)
    if reached < end:
        yield _LineSegment(reached, end, 0.0, 0.0)


def _end_of_drawing(rules: Rules) -> datetime:
    """Until when it is drawn."""
    if rules.closes_at is not None:
        after = max((rules.closes_at - rules.opens_at) / 12, timedelta(hours=1))
        return rules.closes_at + after
    if rules.due_at is None:
        return rules.opens_at + 7 * DAY
    if rules.late is LatePolicy.penalty:
        return rules.due_at + min(math.ceil(MAX_POINTS / rules.late_per_day), 400) * DAY + MARGIN_AFTER_LAST_DATE
    return rules.due_at + max((rules.due_at - rules.opens_at) / 3, MARGIN_AFTER_LAST_DATE)


def _render_svg(rules: Rules, pieces: Sequence[_LineSegment], told: str) -> Markup:
    start, end = pieces[0].start, pieces[-1].end
    length = (end - start) / timedelta(seconds=1) or 1.0

    def x(when: datetime) -> float:
        return LEFT + (RIGHT - LEFT) * ((when - start) / timedelta(seconds=1)) / length

    def y(worth: float | None) -> float:
        return BOTTOM - (BOTTOM - TOP) * (worth or 0.0) / MAX_POINTS

    parts = []
    for mark in (0, 10, 20):
        height = y(mark)
        parts.append(f'<line class="late-axis" x1="{LEFT}" y1="{height:.1f}" x2="{RIGHT}" y2="{height:.1f}"/>')
        parts.append(f'<text x="{LEFT - 6}" y="{height + 4:.1f}" text-anchor="end">{mark}</text>')
    for row, (when, name) in enumerate(_named_dates(rules)):
        place = x(when)
        anchor = "start" if place < LEFT + 70 else "end" if place > RIGHT - 70 else "middle"
        below = BOTTOM + 18 + 15 * row
        here = school_time.to_local(when)
        label = f"{name} {here:%d/%m} {school_time.format_hour(here)}"
        parts.append(f'<line class="late-date" x1="{place:.1f}" y1="{TOP}" x2="{place:.1f}" y2="{below - 11:.1f}"/>')
        parts.append(f'<text x="{place:.1f}" y="{below:.1f}" text-anchor="{anchor}">{escape(label)}</text>')
    path = ""
    for piece in pieces:
        kind = "L" if path else "M"
        path += f"{kind}{x(piece.start):.1f} {y(piece.left):.1f}L{x(piece.end):.1f} {y(piece.right):.1f}"
    parts.append(f'<path class="late-worth" d="{path}"/>')
    return Markup(
        f'<svg class="late-line" viewBox="0 0 {WIDTH:g} {HEIGHT:g}" role="img" aria-label="{escape(told)}">'
        f"{''.join(parts)}</svg>"
    )


def _named_dates(rules: Rules) -> Iterator[tuple[datetime, str]]:
    for when, name in (
        (rules.opens_at, "ouvre"),
        (rules.due_at, "à commencer" if rules.is_test else "à rendre"),
        (rules.closes_at, "ferme"),
    ):
        if when is not None:
            yield when, name


def _sentences(rules: Rules) -> Iterator[str]:
    opens, due, closes = rules.opens_at, rules.due_at, rules.closes_at
    if rules.is_test:
        yield from _test_sentences(rules)
        return
    if due is None:
        until = f"jusqu’au {format_long_time(closes)}" if closes else "sans limite"
        yield f"À partir du {format_long_time(opens)}, {until}, aucun retard n’est compté."
        if closes:
            yield "Ensuite, plus rien ne compte."
        return
    yield f"Du {format_long_time(opens)} au {format_long_time(due)}, tout compte en entier."
    if rules.late is LatePolicy.refuse or (closes is not None and closes <= due):
        yield "Ensuite, plus rien ne compte."
        return
    until = f"jusqu’au {format_long_time(closes)}" if closes else "sans limite"
    if rules.late is LatePolicy.accept:
        yield f"Ensuite, {until}, un envoi compte en entier et il est marqué en retard."
    else:
        yield f"Ensuite, {until}, {_penalty_sentence(rules.late_per_day)}"
    if closes:
        yield "Après la fermeture, plus rien ne compte."


def _test_sentences(rules: Rules) -> Iterator[str]:
    """A test is as late as it was begun."""
    due, closes = rules.due_at, rules.closes_at
    first = min((end for end in (due, closes) if end is not None), default=None)
    begun = (
        f"du {format_long_time(rules.opens_at)} au {format_long_time(first)}"
        if first
        else f"dès le {format_long_time(rules.opens_at)}"
    )
    yield f"Commencé {begun}, tout ce qui est envoyé jusqu’à sa fin compte en entier."
    if due is not None and (closes is None or closes > due):
        if rules.late is LatePolicy.refuse:
            yield "Ensuite, on ne le commence plus ; qui l’a commencé garde son temps."
        elif rules.late is LatePolicy.accept:
            yield "Commencé ensuite, il compte en entier et il est marqué en retard."
        else:
            yield f"Commencé ensuite, {_penalty_sentence(rules.late_per_day)}"
    if closes is not None:
        yield "À la fermeture, il finit pour tous."


def _penalty_sentence(per_day: float) -> str:
    first = max(0.0, MAX_POINTS - per_day)
    days = math.ceil(MAX_POINTS / per_day)
    unit = "point" if per_day < 2 else "points"
    worth = f"chaque jour de retard commencé coûte {format_points(per_day)} {unit} sur 20 : "
    if days == 1:
        return worth + "il ne reste rien dès le premier jour."
    return worth + f"{format_points(first)} au plus le premier jour, et plus rien à partir du {days}e jour."
