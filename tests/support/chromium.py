"""Where Chromium is, if it is installed."""

from __future__ import annotations

import shutil

#: The shell without a window is the same engine, for a quarter less of the processors' time.
NAMES = ("chromium-headless-shell", "chromium", "chromium-browser", "google-chrome")


def chromium() -> str | None:
    """The program of the first that there is."""
    return next(filter(None, map(shutil.which, NAMES)), None)
