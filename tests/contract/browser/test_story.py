"""The story of an exercise in a real browser: wrong, diagnosed, corrected; and the editor's promises."""

from __future__ import annotations

import json

import pytest

from tests.contract.browser.conftest import EXERCISE, ROOT, NewVisit, sync_api

expect, Route = sync_api.expect, sync_api.Route
SOLUTION = (ROOT / "graders/l20/poses/solution.py").read_text(encoding="utf-8")
WRONG = f"""{SOLUTION}

def composer(a, b):
    return np.array([a[0] + b[0], a[1] + b[1], ramener(a[2] + b[2])])
"""


def test_wrong_then_understood_then_right(visit: NewVisit) -> None:
    visitor = visit()
    page = visitor.open()
    expect(page.get_by_role("heading", level=1)).to_be_visible()
    expect(page.locator(".katex").first).to_be_visible()
    assert "Indice 1" in page.locator(".hint-closed").first.inner_text()

    visitor.submit(WRONG)
    verdict = page.locator("#verdict")
    assert 0 < float(verdict.locator(".score").inner_text().split()[0].replace(",", ".")) < 20
    expect(verdict.locator(".diagnosis h3")).to_have_text("La rotation est oubliée")
    first = verdict.locator(".check-failed").first
    for part in ("Donné", "Attendu", "Obtenu"):
        expect(first.get_by_role("heading", name=part)).to_be_visible()
    expect(first.locator(".check-hint")).to_be_visible()
    first.get_by_role("button", name="Rejouer pas à pas").click()
    expect(page.locator("dialog.stepping .steps-status")).to_contain_text("Appel de composer")
    page.keyboard.press("Escape")
    picture = first.locator("img")
    picture.scroll_into_view_if_needed()
    page.wait_for_function("image => image.complete && image.naturalWidth > 100", arg=picture.element_handle())
    hint = page.locator(".hints details").first
    hint.locator("summary").click()
    assert len(hint.locator(".prose").inner_text()) > 20
    expect(page.locator(".account")).to_contain_text("Invité")

    visitor.submit(SOLUTION)
    expect(verdict.locator(".score")).to_contain_text("20")
    expect(verdict.get_by_role("heading", name="Exercice réussi")).to_be_visible()
    expect(page.locator("#corrige summary")).to_be_visible()
    expect(page.locator(".attempts tbody tr")).to_have_count(2)

    page.locator(".attempts tbody tr").last.get_by_role("link").click()
    expect(page.get_by_role("heading", level=1)).to_have_text("Essai n° 1")
    expect(page.locator("#verdict .diagnosis")).to_be_visible()
    page.get_by_role("link", name="Reprendre ce code").click()
    page.wait_for_selector("html.has-editor")
    expect(page.locator(".cm-content")).to_contain_text("a[1] + b[1]")
    page.locator(".cm-content").click()
    page.keyboard.press("Control+z")
    expect(page.locator(".cm-content")).not_to_contain_text("a[1] + b[1]")

    page.goto(visitor.server.address + "/l20")
    row = page.locator(".exercise-list > li", has=page.locator(f"a[href='{EXERCISE}']"))
    expect(row.locator(".own-state")).to_contain_text("Réussi")


def test_the_draft_survives_a_reload_and_the_starter_comes_back(visit: NewVisit) -> None:
    visitor = visit()
    page = visitor.open()
    visitor.write("# mon brouillon\nx = 1\n")
    expect(page.locator("#brouillon")).to_have_text("Brouillon enregistré")
    visitor.open()
    expect(page.locator(".cm-content")).to_contain_text("# mon brouillon")
    page.once("dialog", lambda dialog: dialog.dismiss())
    page.get_by_role("button", name="Code de départ").click()
    expect(page.locator(".cm-content")).to_contain_text("# mon brouillon")
    page.once("dialog", lambda dialog: dialog.accept())
    page.get_by_role("button", name="Code de départ").click()
    expect(page.locator(".cm-content")).to_contain_text("def composer(a, b):")


def test_two_tabs_keep_both_versions_until_one_is_chosen(visit: NewVisit) -> None:
    visitor = visit()
    page = visitor.open()
    visitor.write("a = 1\n")
    other = page.context.new_page()
    other.goto(page.url)
    code, theirs = page.locator(".cm-content"), other.locator(".cm-content")
    expect(theirs).to_contain_text("a = 1")
    theirs.press("Control+a")
    theirs.press_sequentially("b = 2")
    told, told_there = page.locator("#versions"), other.locator("#versions")
    expect(told).to_contain_text("dans un autre onglet")
    expect(code).to_contain_text("a = 1")
    expect(told_there).to_be_visible()  # what was put aside has reached the other tab: the browser holds it

    page.reload()
    expect(code).to_contain_text("b = 2")
    expect(told).to_be_visible()
    told.get_by_role("button", name="Prendre l’autre").click()
    expect(code).to_contain_text("a = 1")
    expect(told).to_be_hidden()

    expect(told_there).to_be_visible()
    expect(theirs).to_contain_text("b = 2")
    told_there.get_by_role("button", name="Garder celle-ci").click()
    expect(told).to_be_visible()
    other.close()
    page.reload()
    expect(code).to_contain_text("b = 2")


@pytest.mark.slow
def test_the_draft_follows_a_visitor_who_becomes_a_guest(visit: NewVisit) -> None:
    visitor = visit()
    page = visitor.open()
    visitor.submit("x = 1\n")
    visitor.write("x = 2  # pas encore envoyé\n")
    visitor.open()
    expect(page.locator(".cm-content")).to_contain_text("pas encore envoyé")


@pytest.mark.slow
def test_the_draft_joins_the_account_that_one_logs_in_to(visit: NewVisit) -> None:
    visitor = visit()
    page = visitor.open()

    def to_the_form(link: str) -> None:
        page.locator(".account").get_by_role("link", name=link).click()

    def enter(button: str) -> None:
        page.fill("#login", "bob-brouillon")
        page.fill("#password", "notes sur la machine")
        page.locator("main").get_by_role("button", name=button).click()
        page.wait_for_selector("html.has-editor")

    visitor.write("x = 1  # sans compte\n")
    to_the_form("Se connecter")
    page.get_by_role("link", name="Créez-en un").click()
    page.fill("#name", "Bob")
    enter("Créer le compte")
    expect(page.locator(".cm-content")).to_contain_text("# sans compte")
    page.locator(".account").get_by_role("button", name="Se déconnecter").click()
    visitor.open()
    expect(page.locator(".cm-content")).not_to_contain_text("# sans compte")
    visitor.write("x = 2  # avant de revenir\n")
    to_the_form("Se connecter")
    enter("Se connecter")
    expect(page.locator(".cm-content")).to_contain_text("# avant de revenir")
    page.locator(".cm-content").click()
    page.keyboard.press("Control+z")
    expect(page.locator(".cm-content")).to_contain_text("# sans compte")


def test_everything_can_be_done_from_the_keyboard(visit: NewVisit) -> None:
    visitor = visit()
    page = visitor.open()
    page.keyboard.press("Tab")
    expect(page.get_by_role("link", name="Aller au contenu")).to_be_focused()
    page.keyboard.press("Tab")
    expect(page.get_by_role("link", name="Aller au code").first).to_be_focused()
    page.keyboard.press("Enter")
    expect(page.locator(".cm-content")).to_be_focused()
    page.keyboard.press("Control+a")
    page.keyboard.type("def composer(a, b):\nreturn [1 / 1, 2, 3]\n")
    page.keyboard.press("Tab")
    page.keyboard.type("x")
    assert page.locator(".cm-line").all_inner_texts()[1:] == ["    return [1 / 1, 2, 3]", "    x"]
    for _ in range(5):
        page.keyboard.press("Backspace")
    page.keyboard.press("Escape")
    page.keyboard.press("Tab")
    expect(page.get_by_role("button", name="Envoyer")).to_be_focused()

    sought = True
    early = f"retry: 100\nevent: status\ndata: {json.dumps({'status': 'running', 'early': True, 'text': ''})}\n\n"

    def answer(route: Route) -> None:
        """Says that the mistake is still sought, as long as it is to be."""
        graded = route.fetch()
        route.fulfill(response=graded, body=early if sought else graded.text())

    page.route("**/evenements", answer)
    page.keyboard.press("Enter")
    visitor.verdict()
    expect(page.locator("#annonce")).to_contain_text("sur 20")
    page.keyboard.press("Control+Shift+Enter")
    verdict = page.locator("[data-part=verdict]")
    expect(verdict.locator("h2").first).to_be_focused()
    verdict.evaluate("part => { part.dataset.early = 'yes'; }")
    sought = False
    page.wait_for_selector("[data-part=verdict]:not([data-early])")
    expect(verdict.locator("h2").first, "the final form takes the place of the early one").to_be_focused()


@pytest.mark.slow
def test_the_columns_can_be_resized_from_the_keyboard(visit: NewVisit) -> None:
    page = visit().open()
    bar = page.get_by_role("separator", name="Largeur de l’énoncé")
    before = page.locator(".statement").bounding_box()
    bar.focus()
    for _ in range(5):
        page.keyboard.press("ArrowRight")
    after = page.locator(".statement").bounding_box()
    assert before is not None
    assert after is not None
    assert after["width"] > before["width"] + 50


@pytest.mark.slow
def test_a_refusal_stands_next_to_the_button_and_keeps_the_code(visit: NewVisit) -> None:
    visitor = visit(expected="413")
    page = visitor.open()
    visitor.write("x = '" + "a" * 70_000 + "'\n")
    page.get_by_role("button", name="Envoyer").click()
    expect(page.get_by_role("alert")).to_contain_text("la limite de")
    expect(page.get_by_role("button", name="Envoyer")).to_have_attribute("aria-disabled", "false")


@pytest.mark.slow
def test_a_server_out_of_reach_is_told(visit: NewVisit) -> None:
    visitor = visit(expected="ERR_FAILED")
    page = visitor.open()
    page.route("**/soumissions", lambda route: route.abort())
    page.get_by_role("button", name="Envoyer").click()
    expect(page.get_by_role("alert")).to_contain_text("Le serveur ne répond pas")


@pytest.mark.slow
def test_polling_takes_over_where_events_do_not_pass(visit: NewVisit) -> None:
    visitor = visit(expected="502")
    page = visitor.open()
    page.route("**/evenements", lambda route: route.fulfill(status=502))
    visitor.submit(SOLUTION)
    expect(page.locator("#verdict .score")).to_contain_text("20")


@pytest.mark.slow
def test_a_stream_that_falls_silent_keeps_no_verdict_back(visit: NewVisit) -> None:
    """As that of a server that is gone without a word: no error ever comes."""
    visitor = visit()
    page, silent = visitor.open(), list[object]()
    page.route("**/evenements", lambda route: silent.append(route))  # noqa: PLW0108
    visitor.submit(SOLUTION)
    expect(page.locator("#verdict .score")).to_contain_text("20")
    assert len(silent) == 1


def test_without_script_the_verdict_comes_too(visit: NewVisit) -> None:
    visitor = visit(java_script_enabled=False)
    page = visitor.page
    page.goto(visitor.server.address + EXERCISE)
    expect(page.get_by_role("button", name="Code de départ")).to_be_hidden()
    page.get_by_role("textbox", name="Votre code").fill(SOLUTION)
    page.get_by_role("button", name="Envoyer").click()
    visitor.verdict()
    expect(page.locator("#verdict .score")).to_contain_text("20")


@pytest.mark.slow
def test_without_the_editor_the_text_area_serves(visit: NewVisit) -> None:
    visitor = visit(expected="éditeur|ERR_FAILED")
    page = visitor.page
    page.route("**/editor*.js", lambda route: route.abort())
    page.goto(visitor.server.address + EXERCISE)
    page.get_by_role("textbox", name="Votre code").fill(SOLUTION)
    page.keyboard.press("Control+Enter")
    visitor.verdict()
    expect(page.locator("#verdict .score")).to_contain_text("20")


@pytest.mark.slow
def test_the_theme_is_kept_and_figures_follow(visit: NewVisit) -> None:
    visitor = visit(color_scheme="light")
    page = visitor.open()
    visitor.submit(WRONG)
    page.get_by_role("button", name="Passer au thème sombre").click()
    picture = page.locator(".check-failed img").first
    picture.scroll_into_view_if_needed()
    page.wait_for_function("image => image.currentSrc.endsWith('dark')", arg=picture.element_handle())
    visitor.open()
    assert page.evaluate("getComputedStyle(document.body).colorScheme || document.documentElement.dataset.theme")
    expect(page.get_by_role("button", name="Passer au thème clair")).to_be_visible()


@pytest.mark.slow
def test_no_page_scrolls_sideways(visit: NewVisit) -> None:
    visitor = visit(width=360, height=740)
    page = visitor.open()
    visitor.submit(WRONG)
    page.evaluate("document.querySelectorAll('details').forEach(one => one.open = true)")
    attempt = page.locator(".attempts a").first.get_attribute("href")
    read = ("/l20/lire/formules", "/l20/lire/localiser", "/l20/glossaire", "/l20/recherche?q=poids")
    account = ("/connexion", "/inscription", "/compte", "/docs")
    for path in (None, "/", "/l20", attempt, *account, f"{EXERCISE}/essais", *read):
        if path is not None:
            page.goto(visitor.server.address + path)
        for width in (768, 360):
            page.set_viewport_size({"width": width, "height": 740})
            if path in read:
                page.wait_for_timeout(300)  # wide formulas are put on lines of their own a little after
            overflow = page.evaluate("document.documentElement.scrollWidth - document.documentElement.clientWidth")
            assert overflow <= 0, (path, width)


LONG = """def f(x):
    return {"a": x, "b": 1e-3}  # fin


class Pose:
    def y(self):
        return f"{self.x}"
"""


@pytest.mark.slow
def test_the_editor_searches_folds_and_closes_brackets(visit: NewVisit) -> None:
    visitor = visit()
    page = visitor.open()
    lines = page.locator(".cm-line")
    visitor.write(LONG)
    page.keyboard.press("Control+Home")
    page.keyboard.press("Control+Shift+BracketLeft")
    expect(lines.first).to_contain_text("…")
    expect(lines).to_have_count(7)
    expect(page.locator(".cm-line span").first).to_have_text("def")
    page.keyboard.press("Control+Shift+BracketRight")
    page.keyboard.press("Control+f")
    expect(page.locator(".cm-search [name=search]")).to_be_focused()
    page.keyboard.type("self")
    page.keyboard.press("Enter")
    expect(page.locator(".cm-searchMatch-selected")).to_have_count(1)
    page.keyboard.press("Escape")
    page.keyboard.press("Control+End")
    page.keyboard.type("(")
    expect(lines.last).to_have_text("()")
