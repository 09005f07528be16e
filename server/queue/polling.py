"""A work source that polls the database at an interval, where nothing wakes the worker."""

import time


class PollingSource:
    buffers_wakeups = False

    def __init__(self, interval: float = 0.1) -> None:
        self._interval = interval

    def wait(self, seconds: float) -> bool:
        time.sleep(min(self._interval, seconds))
        return True
