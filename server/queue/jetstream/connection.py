"""One process's connection to NATS, on a loop and a thread of its own.

It is never waited for on the way of a request: what is posted while nobody hears is dropped and counted, for the
sweeper calls again for what waits, and whoever watches looks by themselves after a while. A lost connection is made
again from scratch, for ever: nothing is buffered for a server that is not there.
"""

from __future__ import annotations

import asyncio
import concurrent.futures
import logging
import ssl
import threading
from collections.abc import Awaitable, Callable, Coroutine
from typing import Any, TypeVar

import nats.errors
from nats.aio.client import Client
from nats.aio.msg import Msg
from nats.js import JetStreamContext

from server.base.counters import DROPPED_NOTIFICATIONS
from server.base.settings import Settings
from server.queue.interfaces import JobNotification
from server.queue.jetstream.credentials import TlsEnforcingClient, connect_options, wants_tls
from server.queue.jetstream.stream_layout import CHANGED, StreamLayout

log = logging.getLogger(__name__)

T = TypeVar("T")
RETRY_AFTER = 0.5  # seconds
CONNECT_SECONDS, PUBLISH_SECONDS, CLOSING_SECONDS = 2, 5.0, 2.0
PING_SECONDS, UNANSWERED = 5, 2
#: Between two tries to publish a ticket.
PAUSES = (0.1, 0.4, 1.5)
#: What is being posted at one time; more is dropped.
MOST_POSTED = 10_000
MOST_NEWS = 100_000
FAILURES = (nats.errors.Error, OSError, ssl.SSLError, asyncio.TimeoutError)


class NatsUnavailableError(Exception):
    """NATS is not reachable now."""


class NatsConnection:
    """`on_changed` is told, on the connection's thread, the news of a job that another process has changed."""

    def __init__(
        self,
        settings: Settings,
        layout: StreamLayout,
        on_changed: Callable[[str], None] | None = None,
        *,
        read_only: bool = False,
    ) -> None:
        """With `only_look`, nothing is made or changed on the server."""
        self.layout, self._only_look = layout, read_only
        self._options, self._tls = connect_options(settings), wants_tls(settings)
        self._on_changed = on_changed
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._run, name="nats", daemon=True)
        self._client: Client | None = None
        self._context: JetStreamContext | None = None
        self._up, self._tried, self._ready = threading.Event(), threading.Event(), threading.Event()
        self._closing = False
        self._posting: set[asyncio.Task[None]] = set()
        self._taken = {"ticket", "news", "answer"}
        self._told = ""

    def start(self) -> None:
        """It connects by itself, and again whenever it has to."""
        self._thread.start()

    def __enter__(self) -> NatsConnection:
        self.start()
        return self

    def __exit__(self, *_exc: object) -> None:
        self.close()

    @property
    def is_up(self) -> bool:
        return self._up.is_set()

    def wait_ready(self, seconds: float) -> bool:
        """Once it has been up, with the stream in its place."""
        return self._ready.wait(seconds)

    def wait_first_attempt(self, seconds: float) -> bool:
        """Once it is up, or was not at the first try; whether it is up."""
        self._tried.wait(seconds)
        return self.is_up

    @property
    def last_error(self) -> str:
        """Why it is not up, in the library's words."""
        return "" if self.is_up else self._told

    @property
    def loop(self) -> asyncio.AbstractEventLoop:
        return self._loop

    @property
    def client(self) -> Client:
        """On the connection's thread. Raises DownError."""
        if self._client is None:
            raise NatsUnavailableError(self._told)
        return self._client

    @property
    def jetstream(self) -> JetStreamContext:
        """On the connection's thread. Raises DownError."""
        if self._context is None:
            raise NatsUnavailableError(self._told)
        return self._context

    @property
    def server_version(self) -> str:
        """Of the server, as it says."""
        if self._client is None:
            return ""
        found = self._client.connected_server_version
        return f"{found.major}.{found.minor}.{found.patch}"

    def publish_job_available(self, notification: JobNotification) -> None:
        """Puts a ticket on the stream, from any thread, without waiting."""
        subject = self.layout.consumer_of_kind(notification.kind).subject
        self._post("ticket", lambda: self._publish(subject, notification))

    def publish_change(self, news: str) -> None:
        """Says that a job has changed, from any thread, without waiting."""
        self._post("news", lambda: self.client.publish(CHANGED, news.encode()))

    def reply(self, ticket: str, word: bytes) -> None:
        """Says what becomes of a ticket, from any thread, without waiting."""
        self._post("answer", lambda: self.client.publish(ticket, word))

    def run_blocking(self, question: Callable[[], Coroutine[Any, Any, T]], seconds: float) -> T:
        """What `question` finds on the connection's thread. Raises DownError, or what it raises."""
        if not self.is_up:
            raise NatsUnavailableError(self._told)
        asked: concurrent.futures.Future[T] = asyncio.run_coroutine_threadsafe(
            asyncio.wait_for(question(), seconds), self._loop
        )
        try:
            return asked.result(seconds + 1.0)
        except FAILURES as error:
            raise NatsUnavailableError(repr(error)) from error

    def close(self) -> None:
        """What is being posted may end; then nothing is heard any more."""
        if not self._thread.is_alive():
            return
        self._closing = True
        try:
            asyncio.run_coroutine_threadsafe(self._leave(), self._loop).result(2 * CLOSING_SECONDS + 1.0)
        except concurrent.futures.TimeoutError:
            log.warning("the connection to NATS is left without a good-bye")
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join(CLOSING_SECONDS)

    def call_on_loop(self, action: Callable[..., object], *arguments: object) -> None:
        """From any thread; nothing once it is closed."""
        if not self._loop.is_closed():
            self._loop.call_soon_threadsafe(action, *arguments)

    async def _publish(self, subject: str, call: JobNotification) -> None:
        """Tried again for a while: a cluster that elects a leader takes nothing."""
        for pause in PAUSES:
            try:
                await self._publish_once(subject, call)
                return
            except FAILURES:
                await asyncio.sleep(pause)
        await self._publish_once(subject, call)

    async def _publish_once(self, subject: str, call: JobNotification) -> None:
        await self.jetstream.publish(subject, b"", timeout=PUBLISH_SECONDS, headers={"Nats-Msg-Id": call.message_id})

    def _post(self, what: str, posting: Callable[[], Awaitable[object]]) -> None:
        if self.is_up and len(self._posting) < MOST_POSTED:
            self.call_on_loop(self._begin_posting, what, posting)
        else:
            DROPPED_NOTIFICATIONS.add(what)

    def _begin_posting(self, what: str, posting: Callable[[], Awaitable[object]]) -> None:
        task = self._loop.create_task(self._posted(what, posting))
        self._posting.add(task)
        task.add_done_callback(self._posting.discard)

    async def _posted(self, what: str, posting: Callable[[], Awaitable[object]]) -> None:
        try:
            await posting()
            self._taken.add(what)
        except (*FAILURES, NatsUnavailableError) as error:
            DROPPED_NOTIFICATIONS.add(what)
            if what in self._taken:  # once, until one is taken again
                log.warning("NATS does not take a %s: %r; what it does not take is made up for later", what, error)
            self._taken.discard(what)

    def _run(self) -> None:
        asyncio.set_event_loop(self._loop)
        self._loop.create_task(self._keep())
        try:
            self._loop.run_forever()
        finally:
            left = asyncio.all_tasks(self._loop)
            for task in left:
                task.cancel()
            self._loop.run_until_complete(asyncio.gather(*left, return_exceptions=True))
            self._loop.close()

    async def _keep(self) -> None:
        """Connected, and again each time that it is lost."""
        while True:
            lost = asyncio.Event()
            client = TlsEnforcingClient(tls=self._tls)
            try:
                await self._connect(client, lost)
                self._told = "lost"
                making = asyncio.create_task(self._make(self.jetstream))
                try:
                    await lost.wait()
                finally:
                    making.cancel()
            except FAILURES as error:
                self._say_why(error)
            except Exception as error:  # of the library, which met something half said: this task must not end
                log.exception("NATS is left, and tried again")
                self._say_why(error)
            finally:
                self._up.clear()
                self._client = self._context = None
                await _left(client)
            if self._closing:  # what cancels this task may have been lost in the good-bye
                return
            await asyncio.sleep(RETRY_AFTER)

    async def _make(self, context: JetStreamContext) -> None:
        """Has the stream stand, as soon as JetStream answers: a cluster that elects a leader does not."""
        told = ""
        while not self._only_look:
            try:
                await self.layout.ensure(context)
                self._ready.set()
                return
            except FAILURES as error:
                if told != (told := repr(error)):
                    log.warning("the stream cannot be made or looked at yet: %s", told)
                await asyncio.sleep(RETRY_AFTER)

    async def _connect(self, client: Client, lost: asyncio.Event) -> None:
        reasons: list[Exception] = []

        async def failed(error: Exception) -> None:
            reasons.append(error)
            if client.is_connected:
                log.warning("NATS: %r", error)

        async def closed() -> None:
            lost.set()

        try:
            await client.connect(
                **self._options,
                allow_reconnect=False,
                max_reconnect_attempts=1,
                reconnect_time_wait=0,
                connect_timeout=CONNECT_SECONDS,
                ping_interval=PING_SECONDS,
                max_outstanding_pings=UNANSWERED,
                no_echo=True,
                name="balise",
                error_cb=failed,
                closed_cb=closed,
            )
        except nats.errors.NoServersError as error:
            raise (reasons[-1] if reasons else error) from error
        if self._on_changed is not None:
            await client.subscribe(CHANGED, cb=self._heard, pending_msgs_limit=MOST_NEWS)
        await client.flush()
        self._client, self._context = client, client.jetstream(timeout=PUBLISH_SECONDS)
        self._up.set()
        self._tried.set()
        if self._told:
            log.warning("NATS answers again")

    def _say_why(self, error: Exception) -> None:
        """Once for each reason: it is tried twice a second."""
        why = str(error) or repr(error)
        if why != self._told and not self._closing:
            log.error("NATS is not reachable, trying again and again: %s", why)
        self._told = why
        self._tried.set()

    async def _heard(self, message: Msg) -> None:
        if self._on_changed is not None:
            self._on_changed(message.data.decode(errors="replace"))

    async def _leave(self) -> None:
        if self._posting:
            await asyncio.wait(self._posting, timeout=CLOSING_SECONDS)
        self._up.clear()
        if self._client is not None:
            await asyncio.wait_for(self._client.close(), CLOSING_SECONDS)


async def _left(client: Client) -> None:
    """Whatever the other end does: there may be none any more."""
    try:
        await asyncio.wait_for(client.close(), CLOSING_SECONDS)
    except Exception as error:
        log.warning("NATS was left without a good-bye: %r", error)
