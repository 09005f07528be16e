"""Objects on the NATS server: one stream of work messages, a consumer for each kind of job, a subject for changes."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from nats.js import JetStreamContext
from nats.js.api import AckPolicy, ConsumerConfig, RetentionPolicy, StorageType, StreamConfig
from nats.js.errors import NotFoundError

from server.base.settings import Settings
from server.queue.interfaces import INTERACTIVE

STREAM = "work"
SUBJECTS = "balise.work.>"
#: Subject of job changes: the key of a job that was claimed, ended or went back.
CHANGED = "balise.changed"
#: Messages not consumed within this time are dropped; the sweeper resends those of waiting jobs.
MAX_AGE_SECONDS = 3600.0
MAX_MESSAGES = 1_000_000
#: A message has headers only; an intruder cannot fill the disk with larger ones.
MAX_MESSAGE_BYTES = 1024
#: Deduplication window of message ids.
DEDUPLICATION_SECONDS = 120.0
#: A message delivered more often is dropped: all workers refuse its job. The job's row counts its own tries.
MAX_DELIVERIES = 200
MAX_WAITING_PULLS, MAX_ACK_PENDING = 8192, 20_000


@dataclass(frozen=True)
class JobConsumer:
    """The durable consumer of one kind of job."""

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
    """`consumers` are in the order in which workers ask them: interactive kinds first."""

    consumers: Sequence[JobConsumer]
    lease_seconds: float
    replicas: int

    def consumer_of_kind(self, kind: str) -> JobConsumer:
        return next(consumer for consumer in self.consumers if consumer.kind == kind)

    def stream_config(self) -> StreamConfig:
        return StreamConfig(
            name=STREAM,
            subjects=[SUBJECTS],
            retention=RetentionPolicy.WORK_QUEUE,
            storage=StorageType.FILE,
            num_replicas=self.replicas,
            max_age=MAX_AGE_SECONDS,
            max_msgs=MAX_MESSAGES,
            max_msg_size=MAX_MESSAGE_BYTES,
            duplicate_window=DEDUPLICATION_SECONDS,
        )

    def consumer_config(self, consumer: JobConsumer) -> ConsumerConfig:
        """Return its configuration: a message is redelivered as its lease ends, when its job may be recovered."""
        return ConsumerConfig(
            durable_name=consumer.consumer_name,
            filter_subject=consumer.subject,
            ack_policy=AckPolicy.EXPLICIT,
            ack_wait=self.lease_seconds,
            max_deliver=MAX_DELIVERIES,
            max_waiting=MAX_WAITING_PULLS,
            max_ack_pending=MAX_ACK_PENDING,
        )

    async def create_or_update(self, context: JetStreamContext) -> None:
        """Create what is missing, and update what differs. Raises nats.js.errors.APIError."""
        try:
            actual = (await context.stream_info(STREAM)).config
            if self._stream_differs(actual):
                await context.update_stream(self.stream_config())
        except NotFoundError:
            await context.add_stream(self.stream_config())
        for consumer in self.consumers:
            await context.add_consumer(STREAM, self.consumer_config(consumer))

    async def find_differences(self, context: JetStreamContext) -> list[str]:
        """Return the differences from the expected state, in French; `create_or_update` removes them."""
        try:
            actual = (await context.stream_info(STREAM)).config
        except NotFoundError:
            return [f"le flux « {STREAM} » n’existe pas encore"]
        differences = [f"le flux « {STREAM} » : {text}" for text in self._stream_differs(actual)]
        for consumer in self.consumers:
            try:
                config = (await context.consumer_info(STREAM, consumer.consumer_name)).config
            except NotFoundError:
                differences.append(f"le consommateur « {consumer.consumer_name} » n’existe pas encore")
                continue
            differences += [
                f"le consommateur « {consumer.consumer_name} » : {text}"
                for text in _differing_fields(config, self.consumer_config(consumer))
            ]
        return differences

    def _stream_differs(self, actual: StreamConfig) -> list[str]:
        return list(_differing_fields(actual, self.stream_config()))


def _differing_fields(actual: object, expected: object) -> Iterator[str]:
    for name in COMPARED_FIELDS:
        expected_value, value = getattr(expected, name, None), getattr(actual, name, None)
        if expected_value is not None and expected_value != value:
            yield f"{name} vaut {value} au lieu de {expected_value}"


COMPARED_FIELDS = (
    *("subjects", "retention", "storage", "num_replicas", "max_age", "max_msgs", "max_msg_size", "duplicate_window"),
    *("filter_subject", "ack_policy", "ack_wait", "max_deliver", "max_waiting", "max_ack_pending"),
)


def build_layout(settings: Settings, lanes: Mapping[str, str]) -> StreamLayout:
    """Return the layout; `lanes` maps each kind of job to `interactive` or `background`."""
    consumers = sorted(
        (JobConsumer(kind, lane) for kind, lane in lanes.items()), key=lambda consumer: consumer.lane != INTERACTIVE
    )
    return StreamLayout(consumers, settings.lease_seconds, settings.nats_replicas)
