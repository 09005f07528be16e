"""A worker's source of work where nothing wakes it: it looks again and again."""

import time


class PollingSource:
    buffers_wakeups = False

    def __init__(self, every: float = 0.1) -> None:
        self._every = every

    def wait(self, seconds: float) -> bool:
        time.sleep(min(self._every, seconds))
        return True
