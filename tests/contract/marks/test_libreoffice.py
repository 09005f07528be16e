"""What a spreadsheet makes of the files: LibreOffice, in French, reads the same marks."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest
import python_calamine

from server.course import Course
from server.database import Database
from server.marks.downloads import GradebookFormat, render_download
from server.marks.files import MoodleIdentifier
from server.marks.loading import load_gradebook
from tests.support.marks import AFTER, ODOMETRY, POSES, Term

OFFICE = shutil.which("soffice")
FRENCH_CSV = "CSV:59,34,76,1,,1036,false,true"  # « ; », quotes, UTF-8, from line 1, French; quoted numbers are numbers


@pytest.mark.slow
@pytest.mark.skipif(OFFICE is None, reason="LibreOffice is not installed (Debian: libreoffice-calc-nogui)")
def test_a_french_spreadsheet_reads_the_marks(sqlite: Database, course: Course, tmp_path: Path) -> None:
    term = Term.begin(sqlite)
    term.assignment("=1+1", {POSES: 1.0})
    term.assignment("DM 2", {ODOMETRY: 1.0})
    for number, points in enumerate((22.5 / 2, 1.33, 20.0, 40 / 3)):
        student = term.student("@SUM(1)", f"+É {number}")
        term.send(student, POSES, points)
        term.send(student, ODOMETRY, 12.5)
    term.student("Ada", "Z")
    with sqlite.read() as db:
        made = load_gradebook(db, course, term.made, AFTER)
    for kind in (GradebookFormat.csv, GradebookFormat.xlsx):
        file = tmp_path / f"{kind}.{kind}"
        file.write_bytes(render_download(made, kind, MoodleIdentifier.email, str).content)
        options = [f"--infilter={FRENCH_CSV}"] if kind is GradebookFormat.csv else []
        home, out = f"-env:UserInstallation=file://{tmp_path}/profile", str(tmp_path / "out")
        command = [str(OFFICE), home, "--headless", *options, "--convert-to", "ods", "--outdir", out, str(file)]
        subprocess.run(command, check=True, capture_output=True, timeout=180)
        read = python_calamine.CalamineWorkbook.from_path(tmp_path / "out" / f"{kind}.ods").get_sheet_by_index(0)
        apostrophe = "'" if kind is GradebookFormat.csv else ""
        header, *rows = read.to_python()
        assert header[4:] == [f"{apostrophe}=1+1", "DM 2", "Moyenne"]
        assert [row[4:] for row in rows] == [
            [11.25, 12.5, 11.88], [1.33, 12.5, 6.92], [20, 12.5, 16.25], [13.33, 12.5, 12.92],
            ["non rendu", "non rendu", ""],
        ]  # fmt: skip
        assert rows[0][:2] == [f"{apostrophe}+É 0", f"{apostrophe}@SUM(1)"]
