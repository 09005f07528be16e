"""`vscode`: a task that sends the open file, and shows what failed on its lines."""

from __future__ import annotations

import json
import sys
from pathlib import Path

from .errors import ClientError

FILE = Path(".vscode", "tasks.json")
PATTERN = {"regexp": r"^(.+):(\d+): (error): (.*)$", "file": 1, "line": 2, "severity": 3, "message": 4}


def write_vscode_tasks(folder: Path, client_path: Path) -> Path:
    """Write the tasks of a folder; return the file. Raises ClientError where there are other tasks already."""
    file = folder / FILE
    task = {
        "label": "Balise : envoyer ce fichier",
        "type": "process",
        "command": sys.executable,
        "args": [str(client_path), "submit", "${file}", "--problems"],
        "group": {"kind": "build", "isDefault": True},
        "presentation": {"clear": True},
        "problemMatcher": {"owner": "balise", "fileLocation": "absolute", "pattern": PATTERN},
    }
    content = json.dumps({"version": "2.0.0", "tasks": [task]}, ensure_ascii=False, indent=2) + "\n"
    if file.exists() and file.read_text(encoding="utf-8") != content:
        wanted = json.dumps(task, ensure_ascii=False, indent=2)
        raise ClientError(f"{file} existe déjà ; ajoutez-y cette tâche :\n{wanted}")
    try:
        file.parent.mkdir(exist_ok=True)
        file.write_text(content, encoding="utf-8")
    except OSError as error:
        raise ClientError(f"impossible d’écrire {file} : {error.strerror}.") from error
    return file
