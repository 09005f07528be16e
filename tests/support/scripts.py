"""The JavaScript that an exercise's page asks for, as it is sent."""

from __future__ import annotations

import re
from pathlib import Path

from server.web import assets

#: What the page names itself; `editor-*.js` is asked for by a script.
NAMED = ("js/theme.js", "js/app.js", "js/exercise.js")
MOST = 100_000  # bytes on the wire, where a browser takes brotli: over HTTPS


def sent() -> dict[str, int]:
    """Bytes of each script, with all that they import. The front end must have been built."""
    editor, *others = (f"js/{path.name}" for path in (assets.BUILT / "js").glob("editor-*.js"))
    assert not others
    scripts, waiting = set[str](), [*NAMED, editor]
    while waiting:
        name = waiting.pop()
        if name not in scripts:
            scripts.add(name)
            text = (assets.BUILT / name).read_text(encoding="utf-8")
            waiting += [f"js/{one}" for one in re.findall(r'(?:from|import)"\./([^"]+)"', text)]
    return {name: min(path.stat().st_size for path in _versions(assets.BUILT / name)) for name in scripts}


def _versions(path: Path) -> list[Path]:
    return [one for one in (path, path.with_name(f"{path.name}.br")) if one.is_file()]
