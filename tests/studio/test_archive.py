"""Archives, imports, codes of colleagues and the bank: what leaves comes back the same, and nothing of a file runs."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path
from typing import Any

import pytest

from graders.core.declared.declaration import read_declaration
from server.cli import main
from server.identity.models import Role
from server.studio.archive import iter_exercise_files, read_archive, unpack_texts, write_archive
from server.studio.authored import LIMITS
from server.studio.completion import complete_draft
from server.studio.dodona import read_exercise
from server.studio.drafts import ExerciseDraft
from server.studio.import_drafts import ImportRefused
from server.studio.importing import import_exercise_file
from server.studio.publication import version_content, version_digest
from server.studio.service import find_own_exercise, read_draft
from tests.graders.declared.kinds import KINDS, Kind
from tests.support.classes import person
from tests.support.outside import taken_in

from .conftest import FORM, MISTAKE, SOLUTION, Studio

RICH: dict[str, Any] = {
    **MISTAKE,
    "resume": "Compter des mots.",
    "niveau": "MPSI",
    "themes": "dictionnaires",
    "indice-1": "Que vaut un compte au début ?",
    "interdits": "Counter",
    "v-0-indice": "Et pour un texte vide ?",
    "v-1-titre": "Des textes au hasard",
    "v-1-points": "7,5",
    "v-1-tirages": 'n = entier(1, 3); t = texte("ab ", n, 9)',
    "v-1-appel": "compter_mots(t)",
    "v-1-combien": "9",
    "v-1-conditions": "n != 2",
    "v-1-stricts": "oui",
    "v-1-tolerance": "1e-6",
    "v-1-absolue": "oui",
}


class NoTrial:
    """Answers nothing, so that nothing is proposed."""

    def answer_written_cases(self, data: object) -> None:
        return None

    def answer_draws(self, data: object) -> list[tuple[str, str]]:
        return []


def completed(draft: ExerciseDraft) -> Any:
    return version_content(complete_draft(draft, NoTrial()))  # type: ignore[arg-type]


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.name)
def test_each_kind_of_exercise_comes_back_the_same(kind: Kind) -> None:
    """From a declaration to a draft, whose archive gives the same draft and the same version again."""
    data = kind.declaration
    content = {
        "title": kind.name, "summary": "x", "statement": "```\n```", "starter": "pass\n", "hints": ["", "b", ""],
        "signatures": {}, "declaration": data,
    }  # fmt: skip
    draft = read_archive(unpack_texts(write_archive("l19", "essai", content, LIMITS)))
    first = completed(draft)
    read_declaration(first["declaration"])
    again = read_archive(unpack_texts(write_archive("l19", "essai", first, LIMITS)))
    assert version_digest(completed(again)["declaration"]) == version_digest(first["declaration"])
    assert completed(again) == first


def test_an_exported_exercise_is_checked_as_it_is_and_comes_back_the_same(
    studio: Studio, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Browser, folder, `balise check`, browser: the same version."""
    monkeypatch.setattr("server.cli.parallel.usable_cores", lambda: 1)  # one exercise: one sandbox is enough
    exercise = studio.publish(**RICH)
    packed = studio.browser.get(f"/mes-exercices/{exercise.id}/archive.zip")
    assert packed.status_code == 200
    course = tmp_path / "cours-studio"
    assert main(["new", "module", "l77", "--course", str(course)]) == 0
    with zipfile.ZipFile(io.BytesIO(packed.content)) as archive:
        for name in archive.namelist():
            place = course / name.replace("/l20/", "/l77/")
            place.parent.mkdir(parents=True, exist_ok=True)
            place.write_bytes(archive.read(name))
    with taken_in(course):
        assert main(["check", f"l77/{exercise.slug}", "--course", str(course)]) == 0
    back = studio.browser.post(
        "/mes-exercices/importer",
        data={"module": "l20"},
        files={"fichier": ("exercice.zip", packed.content, "application/zip")},
    )
    assert back.status_code == 200, back.text
    path = back.text.split('<h2><a href="')[1].split('"')[0]
    draft = read_draft(studio.stored(path))
    assert draft.hints[0] == RICH["indice-1"]
    with studio.site.database.write() as db:
        found = find_own_exercise(db, studio.teacher.account, path.rpartition("/")[2], to_change=True)
        from server.base.app_services import get_service
        from server.studio.service import StudioService

        get_service(studio.site.app, StudioService).save_draft_and_try(
            db, studio.teacher.account, found, draft, publish=True
        )
    studio.work()
    first, second = studio.versions()
    assert first.exercise_id != second.exercise_id
    assert first.version == second.version
    assert first.fingerprints == second.fingerprints


QUESTIONS = (
    '<quiz><question type="coderunner"><name><text>Carrés</text></name><coderunnertype>python3</coderunnertype>'
    "<answer>def carre(n):\n    return n * n\n</answer><testcases>"
    "<testcase><testcode><text>print(carre(3))</text></testcode><expected><text>9</text></expected></testcase>"
    "<testcase><testcode><text></text></testcode><stdin><text>3</text></stdin></testcase></testcases></question></quiz>"
)


@pytest.mark.parametrize(
    ("name", "data", "status", "words"),
    [
        ("quiz.xml", QUESTIONS, 200, "aucune fonction de la solution"),
        ("suite.yaml", "- tab: a\n  testcases:\n  - {expression: carre(3), return: 9}\n", 200, "Compris"),
        ("quiz.xml", '<!DOCTYPE a [<!ENTITY b "c">]><quiz/>', 422, "définit des entités"),
        ("quiz.pdf", "x", 422, "se lisent ici"),
        ("a.zip", "x", 422, "pas un ZIP"),
        ("a.json", "[" * 5000, 422, "JSON"),
        ("a.ipynb", "{}", 422, "notebook"),
        ("", "", 422, "se lisent ici"),
    ],
)
def test_a_file_is_imported_with_its_three_lists(studio: Studio, name: str, data: str, status: int, words: str) -> None:
    answer = studio.browser.post(
        "/mes-exercices/importer", data={"module": "l20"}, files={"fichier": (name or "x", data.encode())}
    )
    assert answer.status_code == status
    assert words in answer.text


SUITE = """- tab: Somme
  testcases:
  - expression: somme("notes.txt")
    input_files: [{path: notes.txt}]
    return: 27
"""


def test_an_exercise_of_dodona_is_taken_with_the_files_beside_its_suite(studio: Studio) -> None:
    files = {
        "somme/config.json": '{"description": {"names": {"nl": "Som", "fr": "Somme des notes"}}}',
        "somme/description/description.nl.md": "Schrijf `somme`.",
        "somme/description/description.fr.md": "Écrivez `somme(nom)`.",
        "somme/description/media/note.png": b"\x89PNG\xff",
        "somme/evaluation/suite.yaml": SUITE,
        "somme/solution/solution.py": "def somme(nom):\n    return sum(map(int, open(nom)))\n",
        "somme/workdir/notes.txt": "12\n15\n",
    }
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        for path, content in files.items():
            archive.writestr(path, content)
    (whole,) = import_exercise_file("somme.zip", packed.getvalue())
    assert not whole.left
    assert not whole.to_look_at
    assert (whole.draft.title, whole.draft.statement) == ("Somme des notes", "Écrivez `somme(nom)`.")
    assert "sum(map(int" in whole.draft.solution
    (case,) = whole.draft.checks[0].cases
    assert case.call == "fichier('notes.txt', '12\\n15\\n')\nsomme('notes.txt')"
    path = studio.create()
    studio.save(
        path,
        titre="Somme",
        solution=whole.draft.solution,
        **{
            "v-0-c-0-appel": case.call,
            "v-0-c-0-attendu": "27",
            "v-0-c-1-appel": "",
            "v-0-c-1-attendu": "",
            "v-0-c-2-appel": "",
        },
    )
    assert "Exemples ✓" in studio.report(path)
    (alone,) = import_exercise_file("suite.yaml", SUITE.encode())
    assert "« notes.txt » manque : importez un ZIP de l’exercice où il est" in alone.left[0]
    with pytest.raises(ImportRefused, match="2 suites de tests"):
        list(read_exercise({"a/suite.yaml": SUITE, "b/suite.yaml": SUITE}))


def test_a_zip_that_unpacks_to_much_is_refused(studio: Studio) -> None:
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("declaration.toml", " " * (8 << 20))
    answer = studio.browser.post(
        "/mes-exercices/importer", data={"module": "l20"}, files={"fichier": ("a.zip", packed.getvalue())}
    )
    assert answer.status_code == 422
    assert "trop grand" in answer.text


def test_colleagues_copy_by_a_code_and_from_the_bank(studio: Studio) -> None:
    exercise = studio.publish(**MISTAKE, niveau="MPSI", themes="dictionnaires")
    path = f"/mes-exercices/{exercise.id}"
    alan = person(studio.site, Role.teacher, "Alan").browser(studio.site)
    assert alan.post("/mes-exercices/copier", data={"code": ""}).status_code == 404
    assert alan.post("/mes-exercices/copier", data={"exercice": str(exercise.id)}).status_code == 404
    studio.save(path, **MISTAKE, action="partager")
    code = studio.stored(path).share_code
    assert code is not None
    copied = alan.post("/mes-exercices/copier", data={"code": f" {code.upper()} "})
    assert copied.status_code == 303
    copy = studio.stored(copied.headers["location"])
    assert read_draft(copy).solution == SOLUTION
    assert copy.number == 0
    studio.save(path, **MISTAKE, action="ne-plus-partager")
    assert alan.post("/mes-exercices/copier", data={"code": code}).status_code == 404
    studio.save(path, **MISTAKE, niveau="PCSI", themes="dictionnaires", action="banque")
    assert "modifié depuis" in studio.browser.get("/mes-exercices").text, "a level was saved, and not published"
    studio.save(path, **MISTAKE, niveau="MPSI", themes="dictionnaires")
    assert "modifié depuis" not in studio.browser.get("/mes-exercices").text, "what was published is back"
    studio.save(path, **MISTAKE, niveau="MPSI", themes="dictionnaires", action="banque")
    assert "modifié depuis" not in studio.browser.get("/mes-exercices").text, "lending changes nothing"
    for query, found in (("", True), ("mpsi dictionnaire", True), ("chaque mot", True), ("piles", False)):
        assert (FORM["titre"] in alan.get("/mes-exercices/banque", params={"q": query}).text) is found, query
    assert alan.post("/mes-exercices/copier", data={"exercice": str(exercise.id)}).status_code == 303


def test_an_archive_is_repeatable() -> None:
    content = completed(ExerciseDraft(solution=SOLUTION))
    assert write_archive("l20", "a", content, LIMITS) == write_archive("l20", "a", content, LIMITS)
    assert dict(iter_exercise_files("l20", "a", content, LIMITS))["graders/l20/a/solution.py"] == SOLUTION
