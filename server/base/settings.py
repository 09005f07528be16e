"""Settings: every one has a default that works, and an environment variable `BALISE_<NAME>`.

`README.md` beside this file is a table of them, which a test holds against the descriptions below.
"""

import os
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from difflib import get_close_matches
from ipaddress import ip_network
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal
from zoneinfo import ZoneInfo, ZoneInfoNotFoundError

from pydantic import Field, field_validator
from pydantic_core import PydanticCustomError
from pydantic_settings import BaseSettings, SettingsConfigDict

from server.base.files import default_data_dir

PREFIX = "BALISE_"
#: Segments that no browser, proxy nor shell writes in two ways, and none of which goes upwards.
_PATH = re.compile(r"(/[A-Za-z0-9_~-][A-Za-z0-9._~-]*)+")
Seconds = Annotated[float, Field(allow_inf_nan=False)]
Count = Annotated[int, Field(ge=1)]

#: A folder of files, each of which holds a setting and has its name, as `balise_database_url`.
SECRETS_DIR = "BALISE_SECRETS_DIR"
#: What is read and is no setting: that folder, and what the commands on a student's own machine read.
OTHER_VARIABLES = frozenset({"BALISE_TOKEN", SECRETS_DIR})


@dataclass(frozen=True)
class BucketSettings:
    """A token bucket: `burst` actions at once, then one every `refill_seconds`."""

    burst: int
    refill_seconds: float


@dataclass(frozen=True)
class Bucket:
    """An attribute of the settings: the bucket whose two settings begin with `name`."""

    name: str

    def __get__(self, settings: object, _owner: type) -> BucketSettings:
        return BucketSettings(getattr(settings, f"{self.name}_burst"), getattr(settings, f"{self.name}_refill_seconds"))


def _doc(default: str) -> dict[str, Any]:
    return {"told": default}


class Settings(BaseSettings):
    """The service's settings. A malformed value stops the start-up: nothing is guessed."""

    model_config = SettingsConfigDict(env_prefix=PREFIX, frozen=True, extra="forbid")

    data_dir: Path = Field(
        default_factory=default_data_dir,
        description="the folder of the data: the SQLite database, figures that were drawn, the lock of its only server",
        json_schema_extra=_doc("`$XDG_DATA_HOME/balise`, or `~/.local/share/balise`"),
    )
    database_url: str | None = Field(
        default=None,
        min_length=1,
        description="the database, `postgresql://user:password@host/name` or `sqlite:///file`; over TLS with "
        "`?sslmode=verify-full&sslrootcert=FILE` behind it",
        json_schema_extra=_doc("SQLite, in the data folder"),
    )
    upgrade_backup_dir: Path | None = Field(
        default=None,
        description="the folder where a backup of a PostgreSQL database is written before its schema is upgraded; a "
        "SQLite file is copied beside itself",
        json_schema_extra=_doc("none: no backup"),
    )
    nats_url: str = Field(
        default="",
        repr=False,
        description="the NATS server that carries the work between machines, `nats://host:4222`, or `tls://…`; those "
        "of a cluster separated by commas; it takes PostgreSQL",
        json_schema_extra=_doc("none: one machine"),
    )
    nats_token: str = Field(
        default="", repr=False, description="the token that NATS asks for", json_schema_extra=_doc("none")
    )
    nats_nkey_file: Path | None = Field(
        default=None,
        description="the file of the seed of the nkey that NATS knows this machine by",
        json_schema_extra=_doc("none"),
    )
    nats_tls_ca: Path | None = Field(
        default=None,
        description="the certificates that vouch for NATS, instead of the machine's; with it, only over TLS",
        json_schema_extra=_doc("none"),
    )
    nats_tls_cert: Path | None = Field(
        default=None, description="the certificate that is shown to NATS", json_schema_extra=_doc("none")
    )
    nats_tls_key: Path | None = Field(
        default=None, description="the key of that certificate", json_schema_extra=_doc("none")
    )
    nats_replicas: int = Field(
        default=1,
        ge=1,
        le=5,
        description="on how many servers of a NATS cluster the stream is kept: 3 for one of three",
    )
    courses: str = Field(
        default="",
        description="folders of courses outside of Balise, separated as in `PATH`",
        json_schema_extra=_doc("none"),
    )
    workers: int = Field(
        default_factory=lambda: os.cpu_count() or 1,
        ge=0,
        le=256,
        description="grading processes that `balise serve` starts; with 0, another machine's `balise worker` grades",
        json_schema_extra=_doc("the number of processors"),
    )

    code_bytes: Count = Field(default=64 * 1024, description="the longest file or answers that one may submit")
    body_bytes: Count = Field(default=512 * 1024, description="the largest request that is read")
    submission_burst: Count = Field(default=20, description="submissions of an account at once")
    submission_refill_seconds: Seconds = Field(
        default=3.0, ge=0, description="then one more after so long; 0: as many as one likes"
    )
    storage_burst: Count = Field(default=64 * 1024, description="KiB of submissions that an account may store at once")
    storage_refill_seconds: Seconds = Field(default=9.0, ge=0, description="then one more after so long")
    waiting_each: Count = Field(default=20, description="submissions of an account that wait; more are refused")
    waiting_from_address: Count = Field(
        default=1000,
        description="submissions from one address that wait, of guests and of accounts each; more are refused",
    )
    guest_burst: Count = Field(
        default=1000,
        description="guests from one address at once; also the log-ins that it tries in vain, to accounts and to "
        "logins of nobody each",
    )
    guest_refill_seconds: Seconds = Field(default=1.0, ge=0, description="then one more after so long")
    sign_up_burst: Count = Field(default=1000, description="accounts that one address opens, or tries to, at once")
    sign_up_refill_seconds: Seconds = Field(default=10.0, ge=0, description="then one more after so long")
    login_burst: Count = Field(default=10, description="log-ins tried to one account from one address, at once")
    login_refill_seconds: Seconds = Field(default=30.0, ge=0, description="then one more after so long")
    save_burst: Count = Field(default=60, description="times that an account saves its work in a test, at once")
    save_refill_seconds: Seconds = Field(default=1.0, ge=0, description="then one more after so long")
    cell_burst: Count = Field(default=30, description="runs of a page's cells by an account at once")
    cell_refill_seconds: Seconds = Field(default=2.0, ge=0, description="then one more after so long")
    step_burst: Count = Field(default=20, description="programs that an account has followed line by line at once")
    step_refill_seconds: Seconds = Field(default=3.0, ge=0, description="then one more after so long")
    cells_at_once: int = Field(default=2, ge=1, le=64, description="cells that run at the same time")
    cells_waiting: int = Field(default=100, ge=0, le=1024, description="cells that wait; more are refused")
    warm_up: bool = Field(
        default=True, description="read the texts and rehearse the graders before somebody asks for them"
    )
    warm_figures: bool = Field(default=True, description="start what draws figures before somebody looks at one")
    session_days: Count = Field(default=180, description="how long a browser stays logged in")
    api_tokens: Count = Field(default=10, description="API tokens that an account may have")
    api_token_days: Count = Field(default=365, description="how long an API token is good for")
    password_link_hours: Count = Field(default=48, description="how long a link to a new password is good for")
    first_password_days: Count = Field(
        default=14,
        description="how long the link to a first password is good for, on the slip that a teacher hands over",
    )
    join_burst: Count = Field(default=10, description="codes of classes that an account tries, at once")
    join_refill_seconds: Seconds = Field(default=30.0, ge=0, description="then one more after so long")
    comment_burst: Count = Field(
        default=20, description="messages of an account at once: comments, questions, words to several students"
    )
    comment_refill_seconds: Seconds = Field(default=6.0, ge=0, description="then one more after so long")
    export_burst: Count = Field(default=3, description="times that one takes one's own data away, at once")
    export_refill_seconds: Seconds = Field(default=1200.0, ge=0, description="then one more after so long")
    left_days: int = Field(
        default=0,
        ge=0,
        description="students whom a class's list or a school's system has made an account are erased so long after "
        "their last class has ended for them, where nothing was heard of them since; 0: when somebody asks for it",
    )
    silent_days: int = Field(
        default=0,
        ge=0,
        description="students of whom nothing was heard for so long are erased; 0: when somebody asks for it",
    )
    guest_days: int = Field(
        default=30,
        ge=0,
        description="guests who have sent and answered nothing, and are in no class, are erased so long after they "
        "came; 0: never",
    )
    erasure_days: int = Field(
        default=30,
        ge=1,
        description="somebody who asks to be erased, and who sits or has sat a test that is not published, is erased "
        "when it is, and so long after the request at the latest",
    )
    trusted_proxy: str = Field(
        default="",
        description="addresses or networks, separated by commas, of the reverse proxies whose `X-Forwarded-For` and "
        "`X-Forwarded-Proto` are believed",
        json_schema_extra=_doc("none"),
    )
    root_path: str = Field(
        default="",
        description="the path under which a reverse proxy serves Balise, as `/balise` where it stands at "
        "`https://lycee.example/balise/`; the proxy may take it off or leave it",
        json_schema_extra=_doc("none"),
    )
    platform_networks: str = Field(
        default="",
        description="networks, separated by commas, where platforms of the school's own may be asked; others are asked "
        "at public addresses alone",
        json_schema_extra=_doc("none"),
    )
    platform_http: bool = Field(
        default=False, description="ask platforms over http too, for trials on one machine: never for a school"
    )
    time_zone: str = Field(
        default="Europe/Paris",
        description="the school's time zone, in which its dates are shown and written, by its IANA name",
        json_schema_extra=_doc("`Europe/Paris`"),
    )

    smtp_host: str = Field(
        default="",
        description="the server that takes the mails that teachers ask for; without it none is sent",
        json_schema_extra=_doc("none: no mails"),
    )
    smtp_port: int = Field(default=587, ge=1, le=65535, description="the port of that server: 587, or 465 with `tls`")
    smtp_tls: Literal["starttls", "tls", "none"] = Field(
        default="starttls",
        description="`starttls`, `tls` from the first byte, or `none`, for a relay on this machine alone",
        json_schema_extra=_doc("`starttls`"),
    )
    smtp_user: str = Field(default="", description="who Balise is to that server", json_schema_extra=_doc("none"))
    smtp_password: str = Field(
        default="", repr=False, description="the password of that user there", json_schema_extra=_doc("none")
    )
    smtp_from: str = Field(
        default="",
        pattern=r"^([A-Za-z0-9._+-]+@[A-Za-z0-9-]+(\.[A-Za-z0-9-]+)+)?$",
        description="the address that mails come from",
        json_schema_extra=_doc("`BALISE_SMTP_USER`, where that is an address"),
    )
    smtp_ca: Path | None = Field(
        default=None,
        description="the certificates that vouch for that server, instead of the machine's",
        json_schema_extra=_doc("none"),
    )
    log_format: Literal["text", "json"] = Field(
        default="text",
        description="`text` for people, `json` for one object a line, with the requests and what came of them",
        json_schema_extra=_doc("`text`"),
    )
    metrics_token: str = Field(
        default="",
        repr=False,
        description="what Prometheus shows to read `/metrics`, as a bearer token; without it nobody reads them",
        json_schema_extra=_doc("none"),
    )
    lease_seconds: Seconds = Field(
        default=30.0, gt=0, description="a worker that has given no sign of life for so long loses its submission"
    )
    poll_seconds: Seconds = Field(
        default=1.0, gt=0, description="how often a worker looks for work that nothing announced"
    )
    grading_seconds: Seconds = Field(
        default=600.0, gt=0, description="a grading that takes longer is given up, with its worker"
    )
    version_seconds: Seconds = Field(
        default=120.0,
        ge=0,
        description="with NATS, how long a submission that a worker of another version of its exercise has refused "
        "waits for one of its own; then any grades it",
    )

    @field_validator("trusted_proxy", "platform_networks")
    @classmethod
    def _require_addresses(cls, text: str) -> str:
        """uvicorn takes what is no address for a name that never comes, without a word."""
        for address in _split_list(text):
            try:
                ip_network(address)
            except ValueError as error:
                raise PydanticCustomError("no_address", "not an address", {"address": address}) from error
        return text

    @field_validator("root_path")
    @classmethod
    def _normalise_root_path(cls, text: str) -> str:
        path = text.rstrip("/")
        if path and not _PATH.fullmatch(path):
            raise PydanticCustomError("no_path", "not a path", {"path": text})
        return path

    @field_validator("time_zone")
    @classmethod
    def _require_known_zone(cls, name: str) -> str:
        try:
            ZoneInfo(name)
        except (ValueError, OSError, ZoneInfoNotFoundError) as error:
            raise PydanticCustomError("no_zone", "not a time zone", {"name": name}) from error
        return name

    @property
    def trusted_proxies(self) -> tuple[str, ...]:
        return tuple(_split_list(self.trusted_proxy))

    @property
    def sqlalchemy_url(self) -> str:
        """The database's SQLAlchemy address."""
        if self.database_url is None:
            return f"sqlite:///{self.data_dir / 'balise.sqlite3'}"
        return self.database_url.replace("postgresql://", "postgresql+psycopg://", 1)

    @property
    def on_postgres(self) -> bool:
        return self.sqlalchemy_url.startswith("postgresql")

    submission_bucket: ClassVar[Bucket] = Bucket("submission")
    storage_bucket: ClassVar[Bucket] = Bucket("storage")
    guest_bucket: ClassVar[Bucket] = Bucket("guest")
    sign_up_bucket: ClassVar[Bucket] = Bucket("sign_up")
    export_bucket: ClassVar[Bucket] = Bucket("export")
    comment_bucket: ClassVar[Bucket] = Bucket("comment")
    join_bucket: ClassVar[Bucket] = Bucket("join")
    login_bucket: ClassVar[Bucket] = Bucket("login")
    save_bucket: ClassVar[Bucket] = Bucket("save")
    cell_bucket: ClassVar[Bucket] = Bucket("cell")
    step_bucket: ClassVar[Bucket] = Bucket("step")


def _split_list(text: str) -> list[str]:
    return [piece.strip() for piece in text.split(",") if piece.strip()]


def variable_name(field: str) -> str:
    """The environment's name of a setting."""
    return f"{PREFIX}{field.upper()}"


def misspelt_variables(environment: Iterable[str]) -> Iterator[tuple[str, str | None]]:
    """The variables that look like settings and are none, each with the setting that was probably meant."""
    for name in sorted(environment):
        field = name.lower().removeprefix(PREFIX.lower())
        known = field in Settings.model_fields or name in OTHER_VARIABLES
        if name.upper().startswith(PREFIX) and not known:
            close = get_close_matches(field, Settings.model_fields, n=1)
            yield name, variable_name(close[0]) if close else None
