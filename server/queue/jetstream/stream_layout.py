"""What stands on the NATS server: one stream of tickets, a consumer for each kind of job, two subjects for news."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from nats.js import JetStreamContext
from nats.js.api import AckPolicy, ConsumerConfig, RetentionPolicy, StorageType, StreamConfig
from nats.js.errors import NotFoundError

from server.base.settings import Settings
from server.queue.interfaces import INTERACTIVE

STREAM = "work"
SUBJECTS = "balise.work.>"
#: The key of a job that has begun, ended or gone back.
CHANGED = "balise.changed"
#: Tickets that nobody has taken in this time are dropped: the sweeper calls again for what waits.
MOST_AGE = 3600.0
MOST_TICKETS = 1_000_000
#: A ticket is a name, in its headers: whoever enters NATS fills no disk with more.
LONGEST_TICKET = 1024
#: How long the stream knows a ticket's name: the same one is not taken twice.
SAME_NAME_SECONDS = 120.0
#: A ticket passed on so often is dropped: it bounces between workers that all refuse what waits. The tries of a job are
#: counted by its row.
MOST_DELIVERIES = 200
MOST_PULLS, MOST_HELD = 8192, 20_000


@dataclass(frozen=True)
class JobConsumer:
    """Where the tickets of one kind of job wait."""

    kind: str
    lane: str

    @property
    def subject(self) -> str:
        return f"balise.work.{self.lane}.{self.kind}"

    @property
    def consumer_name(self) -> str:
        return f"{self.lane}_{self.kind}"


@dataclass(frozen=True)
class StreamLayout:
    """`desks`: what somebody waits for comes first."""

    consumers: Sequence[JobConsumer]
    lease_seconds: float
    replicas: int

    def consumer_of_kind(self, kind: str) -> JobConsumer:
        return next(desk for desk in self.consumers if desk.kind == kind)

    def stream_config(self) -> StreamConfig:
        return StreamConfig(
            name=STREAM,
            subjects=[SUBJECTS],
            retention=RetentionPolicy.WORK_QUEUE,
            storage=StorageType.FILE,
            num_replicas=self.replicas,
            max_age=MOST_AGE,
            max_msgs=MOST_TICKETS,
            max_msg_size=LONGEST_TICKET,
            duplicate_window=SAME_NAME_SECONDS,
        )

    def consumer_config(self, desk: JobConsumer) -> ConsumerConfig:
        """A ticket is passed on when its lease ends: by then its holder's job may be taken back."""
        return ConsumerConfig(
            durable_name=desk.consumer_name,
            filter_subject=desk.subject,
            ack_policy=AckPolicy.EXPLICIT,
            ack_wait=self.lease_seconds,
            max_deliver=MOST_DELIVERIES,
            max_waiting=MOST_PULLS,
            max_ack_pending=MOST_HELD,
        )

    async def ensure(self, context: JetStreamContext) -> None:
        """Makes what is missing, and changes what is otherwise. Raises nats.js.errors.APIError."""
        try:
            found = (await context.stream_info(STREAM)).config
            if self._stream_differs(found):
                await context.update_stream(self.stream_config())
        except NotFoundError:
            await context.add_stream(self.stream_config())
        for desk in self.consumers:
            await context.add_consumer(STREAM, self.consumer_config(desk))

    async def find_differences(self, context: JetStreamContext) -> list[str]:
        """What is not as it should be, in French; `ensure` puts it right."""
        try:
            found = (await context.stream_info(STREAM)).config
        except NotFoundError:
            return [f"le flux « {STREAM} » n’existe pas encore"]
        told = [f"le flux « {STREAM} » : {text}" for text in self._stream_differs(found)]
        for desk in self.consumers:
            try:
                config = (await context.consumer_info(STREAM, desk.consumer_name)).config
            except NotFoundError:
                told.append(f"le consommateur « {desk.consumer_name} » n’existe pas encore")
                continue
            told += [
                f"le consommateur « {desk.consumer_name} » : {text}"
                for text in _differs(config, self.consumer_config(desk))
            ]
        return told

    def _stream_differs(self, found: StreamConfig) -> list[str]:
        return list(_differs(found, self.stream_config()))


def _differs(found: object, wanted: object) -> Iterator[str]:
    for name in FIELDS:
        here, there = getattr(wanted, name, None), getattr(found, name, None)
        if here is not None and here != there:
            yield f"{name} vaut {there} au lieu de {here}"


FIELDS = (
    *("subjects", "retention", "storage", "num_replicas", "max_age", "max_msgs", "max_msg_size", "duplicate_window"),
    *("filter_subject", "ack_policy", "ack_wait", "max_deliver", "max_waiting", "max_ack_pending"),
)


def build_layout(settings: Settings, lanes: Mapping[str, str]) -> StreamLayout:
    """`lanes`: of each kind of job, whether somebody waits for it."""
    desks = sorted((JobConsumer(kind, lane) for kind, lane in lanes.items()), key=lambda desk: desk.lane != INTERACTIVE)
    return StreamLayout(desks, settings.lease_seconds, settings.nats_replicas)
