"""Building `balise.pyz`: a zip application of the standard library alone (PEP 441)."""

import io
import zipfile
from functools import lru_cache
from pathlib import Path

from server.base.version import VERSION

PROGRAM = Path(__file__).with_name("program")
PACKAGE = "balise"
MAX_BYTES = 60 * 1024
SHEBANG = b"#!/usr/bin/env python3\n"
#: The earliest date of a ZIP member: equal sources give equal bytes.
FIXED_DATE = (1980, 1, 1, 0, 0, 0)
MAIN = f"import sys\n\nfrom {PACKAGE}.commands import main\n\nsys.exit(main())\n"


@lru_cache(maxsize=8)
def build_client_archive(server_address: str) -> bytes:
    """Return the client for a server (its address, without a slash at the end)."""
    release = f"SERVER = {server_address!r}\nVERSION = {VERSION!r}\n"
    members = {"__main__.py": MAIN, f"{PACKAGE}/release.py": release}
    for path in sorted(PROGRAM.glob("*.py")):
        if path.name != "release.py":
            members[f"{PACKAGE}/{path.name}"] = path.read_text(encoding="utf-8")
    buffer = io.BytesIO(SHEBANG)
    buffer.seek(0, io.SEEK_END)
    with zipfile.ZipFile(buffer, "a", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
        for name, text in sorted(members.items()):
            member = zipfile.ZipInfo(name, FIXED_DATE)
            member.compress_type = zipfile.ZIP_DEFLATED
            member.external_attr = 0o644 << 16
            archive.writestr(member, text)
    return buffer.getvalue()
