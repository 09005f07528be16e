"""One process's connection to NATS, on an event loop and a thread of its own.

No request waits for it: a message that cannot be sent is dropped and counted, since the sweeper resends messages of
waiting jobs and watchers poll. A lost connection is made anew, for ever; nothing is buffered meanwhile.
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
from server.queue.jetstream.credentials import TlsEnforcingClient, connect_options, requires_tls
from server.queue.jetstream.stream_layout import CHANGED, StreamLayout

log = logging.getLogger(__name__)

T = TypeVar("T")
RETRY_AFTER = 0.5  # seconds
CONNECT_SECONDS, PUBLISH_SECONDS, CLOSING_SECONDS = 2, 5.0, 2.0
PING_SECONDS, MAX_UNANSWERED_PINGS = 5, 2
#: Backoff in seconds between tries to publish a message.
PUBLISH_BACKOFF = (0.1, 0.4, 1.5)
#: Maximum number of messages being sent; more are dropped.
MAX_SENDING = 10_000
MAX_PENDING_CHANGES = 100_000
FAILURES = (nats.errors.Error, OSError, ssl.SSLError, asyncio.TimeoutError)


class NatsUnavailableError(Exception):
    """NATS is not reachable now."""


class NatsConnection:
    """`on_changed` receives, on the connection's thread, job changes made by other processes."""

    def __init__(
        self,
        settings: Settings,
        layout: StreamLayout,
        on_changed: Callable[[str], None] | None = None,
        *,
        read_only: bool = False,
    ) -> None:
        """With `read_only`, nothing is created or changed on the server."""
        self.layout, self._read_only = layout, read_only
        self._options, self._requires_tls = connect_options(settings), requires_tls(settings)
        self._on_changed = on_changed
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._run, name="nats", daemon=True)
        self._client: Client | None = None
        self._context: JetStreamContext | None = None
        self._is_up, self._attempted, self._ready = threading.Event(), threading.Event(), threading.Event()
        self._closing = False
        self._sending: set[asyncio.Task[None]] = set()
        self._accepted_kinds = {"ticket", "news", "answer"}
        self._last_error = ""

    def start(self) -> None:
        """Connect, and reconnect whenever the connection is lost."""
        self._thread.start()

    def __enter__(self) -> NatsConnection:
        self.start()
        return self

    def __exit__(self, *_exc: object) -> None:
        self.close()

    @property
    def is_up(self) -> bool:
        return self._is_up.is_set()

    def wait_ready(self, seconds: float) -> bool:
        """Wait until it has been up with the stream in place; return whether it has."""
        return self._ready.wait(seconds)

    def wait_first_attempt(self, seconds: float) -> bool:
        """Wait until the first attempt has succeeded or failed; return whether it is up."""
        self._attempted.wait(seconds)
        return self.is_up

    @property
    def last_error(self) -> str:
        """Why it is not up, as the library says."""
        return "" if self.is_up else self._last_error

    @property
    def loop(self) -> asyncio.AbstractEventLoop:
        return self._loop

    @property
    def connected_client(self) -> Client:
        """The client, for the connection's thread; never connects. Raises NatsUnavailableError while down."""
        if self._client is None:
            raise NatsUnavailableError(self._last_error)
        return self._client

    @property
    def jetstream(self) -> JetStreamContext:
        """The JetStream context, for the connection's thread. Raises NatsUnavailableError."""
        if self._context is None:
            raise NatsUnavailableError(self._last_error)
        return self._context

    @property
    def server_version(self) -> str:
        """The server's version; empty while disconnected."""
        if self._client is None:
            return ""
        version = self._client.connected_server_version
        return f"{version.major}.{version.minor}.{version.patch}"

    def publish_job_available(self, notification: JobNotification) -> None:
        """Publish a work message; from any thread, without waiting."""
        subject = self.layout.consumer_of_kind(notification.kind).subject
        self._send("ticket", lambda: self._publish(subject, notification))

    def publish_change(self, notification: str) -> None:
        """Publish a job change; from any thread, without waiting."""
        self._send("news", lambda: self.connected_client.publish(CHANGED, notification.encode()))

    def reply(self, reply_subject: str, payload: bytes) -> None:
        """Acknowledge or reject a work message; from any thread, without waiting."""
        self._send("answer", lambda: self.connected_client.publish(reply_subject, payload))

    def run_blocking(self, query: Callable[[], Coroutine[Any, Any, T]], seconds: float) -> T:
        """Run a coroutine on the connection's thread; return its result. Raises NatsUnavailableError, or its error."""
        if not self.is_up:
            raise NatsUnavailableError(self._last_error)
        future: concurrent.futures.Future[T] = asyncio.run_coroutine_threadsafe(
            asyncio.wait_for(query(), seconds), self._loop
        )
        try:
            return future.result(seconds + 1.0)
        except FAILURES as error:
            raise NatsUnavailableError(repr(error)) from error

    def close(self) -> None:
        """Let pending messages be sent, then disconnect."""
        if not self._thread.is_alive():
            return
        self._closing = True
        try:
            asyncio.run_coroutine_threadsafe(self._close_client(), self._loop).result(2 * CLOSING_SECONDS + 1.0)
        except concurrent.futures.TimeoutError:
            log.warning("the connection to NATS is left without a good-bye")
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join(CLOSING_SECONDS)

    def call_on_loop(self, action: Callable[..., object], *arguments: object) -> None:
        """Call `action` on the connection's loop, from any thread; do nothing once it is closed."""
        if not self._loop.is_closed():
            self._loop.call_soon_threadsafe(action, *arguments)

    async def _publish(self, subject: str, call: JobNotification) -> None:
        """Publish with retries: a cluster that elects a leader accepts nothing."""
        for pause in PUBLISH_BACKOFF:
            try:
                await self._publish_once(subject, call)
                return
            except FAILURES:
                await asyncio.sleep(pause)
        await self._publish_once(subject, call)

    async def _publish_once(self, subject: str, call: JobNotification) -> None:
        await self.jetstream.publish(subject, b"", timeout=PUBLISH_SECONDS, headers={"Nats-Msg-Id": call.message_id})

    def _send(self, kind: str, operation: Callable[[], Awaitable[object]]) -> None:
        if self.is_up and len(self._sending) < MAX_SENDING:
            self.call_on_loop(self._start_sending, kind, operation)
        else:
            DROPPED_NOTIFICATIONS.add(kind)

    def _start_sending(self, kind: str, operation: Callable[[], Awaitable[object]]) -> None:
        task = self._loop.create_task(self._try_to_send(kind, operation))
        self._sending.add(task)
        task.add_done_callback(self._sending.discard)

    async def _try_to_send(self, kind: str, operation: Callable[[], Awaitable[object]]) -> None:
        try:
            await operation()
            self._accepted_kinds.add(kind)
        except (*FAILURES, NatsUnavailableError) as error:
            DROPPED_NOTIFICATIONS.add(kind)
            if kind in self._accepted_kinds:  # log once, until one is accepted again
                log.warning("NATS does not take a %s: %r; the sweeper or polling recovers it", kind, error)
            self._accepted_kinds.discard(kind)

    def _run(self) -> None:
        asyncio.set_event_loop(self._loop)
        self._loop.create_task(self._keep_connected())
        try:
            self._loop.run_forever()
        finally:
            tasks = asyncio.all_tasks(self._loop)
            for task in tasks:
                task.cancel()
            self._loop.run_until_complete(asyncio.gather(*tasks, return_exceptions=True))
            self._loop.close()

    async def _keep_connected(self) -> None:
        """Connect, and again each time that the connection is lost."""
        while True:
            lost = asyncio.Event()
            client = TlsEnforcingClient(tls=self._requires_tls)
            try:
                await self._connect(client, lost)
                self._last_error = "lost"
                layout_task = asyncio.create_task(self._ensure_layout(self.jetstream))
                try:
                    await lost.wait()
                finally:
                    layout_task.cancel()
            except FAILURES as error:
                self._report_failure(error)
            except Exception as error:  # of the library, which met something half said: this task must not end
                log.exception("the connection to NATS failed, it is tried again")
                self._report_failure(error)
            finally:
                self._is_up.clear()
                self._client = self._context = None
                await _close_quietly(client)
            if self._closing:  # the cancellation of this task may have been lost while closing
                return
            await asyncio.sleep(RETRY_AFTER)

    async def _ensure_layout(self, context: JetStreamContext) -> None:
        """Create or update the stream as soon as JetStream answers: a cluster that elects a leader does not."""
        last_error = ""
        while not self._read_only:
            try:
                await self.layout.create_or_update(context)
                self._ready.set()
                return
            except FAILURES as error:
                if last_error != (last_error := repr(error)):
                    log.warning("the stream cannot be made or looked at yet: %s", last_error)
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
                max_outstanding_pings=MAX_UNANSWERED_PINGS,
                no_echo=True,
                name="balise",
                error_cb=failed,
                closed_cb=closed,
            )
        except nats.errors.NoServersError as error:
            raise (reasons[-1] if reasons else error) from error
        if self._on_changed is not None:
            await client.subscribe(CHANGED, cb=self._receive_change, pending_msgs_limit=MAX_PENDING_CHANGES)
        await client.flush()
        self._client, self._context = client, client.jetstream(timeout=PUBLISH_SECONDS)
        self._is_up.set()
        self._attempted.set()
        if self._last_error:
            log.warning("NATS answers again")

    def _report_failure(self, error: Exception) -> None:
        """Log each reason once: it is tried twice a second."""
        reason = str(error) or repr(error)
        if reason != self._last_error and not self._closing:
            log.error("NATS is not reachable, trying again and again: %s", reason)
        self._last_error = reason
        self._attempted.set()

    async def _receive_change(self, message: Msg) -> None:
        if self._on_changed is not None:
            self._on_changed(message.data.decode(errors="replace"))

    async def _close_client(self) -> None:
        if self._sending:
            await asyncio.wait(self._sending, timeout=CLOSING_SECONDS)
        self._is_up.clear()
        if self._client is not None:
            await asyncio.wait_for(self._client.close(), CLOSING_SECONDS)


async def _close_quietly(client: Client) -> None:
    """Close whatever the other end does: there may be none any more."""
    try:
        await asyncio.wait_for(client.close(), CLOSING_SECONDS)
    except Exception as error:
        log.warning("NATS was left without a good-bye: %r", error)
