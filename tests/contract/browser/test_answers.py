"""Exercises answered without code in a real browser: numbers typed, options ticked, steps moved in every way."""

from __future__ import annotations

from typing import Any

import pytest

from tests.contract.browser.conftest import NewVisit, Visit, sync_api
from tests.contract.browser.test_accessibility import CHECKED_ONCE, check
from tests.support.quick import the_course

expect = sync_api.expect
HOME = "/l20/exercices"


def right(page: Any) -> dict[str, Any]:
    """The right answers to the questions on the page."""
    form = page.locator("#essai")
    grader = the_course().exercises[form.get_attribute("data-exercise")].answers
    assert grader is not None
    return dict(grader.right_answers(int(form.get_attribute("data-seed"))))


def send(visitor: Visit, score: str) -> None:
    page = visitor.page
    page.evaluate("document.querySelector('[data-part=verdict]').dataset.status = 'old'")
    page.get_by_role("button", name="Envoyer").click()
    visitor.verdict()
    expect(page.locator("#verdict .score")).to_contain_text(score)
    page.evaluate("document.querySelectorAll('details').forEach(one => one.open = true)")


def test_numbers_are_typed_kept_and_judged(visit: NewVisit) -> None:
    visitor = visit()
    page = visitor.open(f"{HOME}/calcul_odometrie")
    expect(page.locator(".given-data .katex").first).to_be_visible()
    page.get_by_label("Réponse").first.fill("12 rad")
    expect(page.locator("#brouillon")).to_have_text("Brouillon enregistré")
    page.reload()
    expect(page.get_by_label("Réponse").first).to_have_value("12 rad")
    send(visitor, "0")
    beside = page.locator("#question-ds .question-mark")
    expect(beside).to_contain_text("sans unité")
    expect(beside).to_contain_text("À revoir")
    check(visitor, "numbers, wrong", exclude=CHECKED_ONCE)
    for name, value in right(page).items():
        page.locator(f"#champ-{name}").fill(f"{value:.6f}".replace(".", ","))
    page.get_by_label("Réponse").last.press("Enter")
    expect(page.locator("#verdict .score")).to_contain_text("20")
    expect(page.locator("#corrige .katex").first).to_be_attached()


def test_options_are_ticked_and_explained(visit: NewVisit) -> None:
    visitor = visit(width=390, height=840)
    page = visitor.open(f"{HOME}/verification")
    for question, letters in right(page).items():
        for letter in letters:
            page.locator(f"input[name='q.{question}'][value='{letter}']").check()
    send(visitor, "20")
    expect(page.locator(".question-mark-good .message").first).to_contain_text("Oui.")
    expect(page.locator("#question-qos .question-mark-head")).to_contain_text("Juste")
    check(visitor, "options, right", exclude=CHECKED_ONCE)
    page.locator(".attempts a").first.click()
    expect(page.locator(".told dt").first).to_have_text("Particules ou Kalman")
    check(visitor, "options, attempt")


@pytest.mark.slow
def test_steps_are_moved_by_buttons_keys_and_hand(visit: NewVisit) -> None:
    visitor = visit(width=1280, height=1500)
    page = visitor.open(f"{HOME}/demo_1")
    proof, pool = page.locator("ol.pieces"), page.locator("ul.pieces")
    wanted = right(page)["ordre"]
    check(visitor, "steps, fresh", exclude=CHECKED_ONCE)
    first, second, third, *others = wanted

    page.get_by_role("button", name=f"Placer l’étape {second}").click()
    expect(page.locator("#annonce")).to_have_text(f"Étape {second} : place 1 sur 1")
    handle = page.get_by_role("button", name=f"Étape {first} : déplacer")
    handle.focus()
    page.keyboard.press("ArrowRight")
    page.keyboard.press("ArrowUp")
    expect(handle).to_be_focused()
    expect(page.locator("#annonce")).to_have_text(f"Étape {first} : place 1 sur 2")
    assert letters(proof) == [first, second]

    drag(visitor, third, proof, below=True)
    assert letters(proof) == [first, second, third]
    drag(visitor, third, pool)
    assert letters(proof) == [first, second]
    for letter in (third, *others):
        page.get_by_role("button", name=f"Placer l’étape {letter}").click()
    page.reload()
    assert letters(proof) == wanted, "the draft is kept"
    page.get_by_role("button", name=f"Monter l’étape {wanted[-1]}").click()
    send(visitor, "18")
    check(visitor, "steps, wrong", exclude=CHECKED_ONCE)
    page.get_by_role("button", name=f"Descendre l’étape {wanted[-1]}").click()
    send(visitor, "20")


def letters(pieces: Any) -> list[str]:
    return [one.get_attribute("data-piece") for one in pieces.locator(".piece").all()]


def drag(visitor: Visit, letter: str, target: Any, *, below: bool = False) -> None:
    page = visitor.page
    source = page.locator(f".piece[data-piece='{letter}'] .handle")
    source.scroll_into_view_if_needed()
    start, end = source.bounding_box(), target.bounding_box()
    page.mouse.move(start["x"] + 8, start["y"] + 8)
    page.mouse.down()
    page.mouse.move(end["x"] + 60, end["y"] + 20, steps=3)
    page.mouse.move(end["x"] + 60, end["y"] + (end["height"] - 4 if below else 4), steps=3)
    page.mouse.up()


@pytest.mark.slow
def test_without_script_steps_have_a_number_each(visit: NewVisit) -> None:
    visitor = visit(java_script_enabled=False)
    page = visitor.open(f"{HOME}/demo_1")
    for place, letter in enumerate(right(page)["ordre"], 1):
        page.locator(f"select[name='place.ordre.{letter}']").select_option(str(place))
    page.get_by_role("button", name="Envoyer").click()
    expect(page.locator("#verdict .score")).to_contain_text("20")
