"""What is done again and again while the service runs, in a thread."""

import asyncio
import logging
from collections.abc import Callable

from starlette.concurrency import run_in_threadpool

log = logging.getLogger(__name__)


async def keep(seconds: float, doing: Callable[[], None], failed: str) -> None:
    """Until it is cancelled, whatever `doing` raises: that is logged, as `failed`."""
    while True:
        await asyncio.sleep(seconds)
        try:
            await run_in_threadpool(doing)
        except Exception:
            log.exception(failed)
