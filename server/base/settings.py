"""Settings: every one has a default that works, and an environment variable `BALISE_<NAME>`."""

import os
from dataclasses import dataclass
from pathlib import Path

from pydantic import Field
from pydantic_settings import BaseSettings, SettingsConfigDict

from server.base.paths import default_data_dir


@dataclass(frozen=True)
class Bucket:
    """A token bucket: `burst` actions at once, then one every `refill_seconds`."""

    burst: int
    refill_seconds: float


class Settings(BaseSettings):
    """The service's settings. A malformed value stops the start-up: nothing is guessed."""

    model_config = SettingsConfigDict(env_prefix="BALISE_", frozen=True, extra="forbid")

    data_dir: Path = Field(default_factory=default_data_dir)
    database_url: str | None = None
    workers: int = Field(default_factory=lambda: os.cpu_count() or 1, ge=0, le=256)

    code_bytes: int = Field(default=64 * 1024, ge=1)
    body_bytes: int = Field(default=512 * 1024, ge=1)
    submission_burst: int = Field(default=20, ge=1)
    submission_refill_seconds: float = Field(default=3.0, ge=0)
    guest_burst: int = Field(default=300, ge=1)
    guest_refill_seconds: float = Field(default=1.0, ge=0)
    login_burst: int = Field(default=10, ge=1)
    login_refill_seconds: float = Field(default=30.0, ge=0)
    cell_burst: int = Field(default=30, ge=1)
    cell_refill_seconds: float = Field(default=2.0, ge=0)
    cells_at_once: int = Field(default=2, ge=1, le=64)
    cells_waiting: int = Field(default=16, ge=0, le=1024)
    session_days: int = Field(default=180, ge=1)

    lease_seconds: float = Field(default=30.0, gt=0)
    poll_seconds: float = Field(default=1.0, gt=0)
    grading_seconds: float = Field(default=600.0, gt=0)

    @property
    def url(self) -> str:
        """The database's SQLAlchemy address."""
        if self.database_url is None:
            return f"sqlite:///{self.data_dir / 'balise.sqlite3'}"
        return self.database_url.replace("postgresql://", "postgresql+psycopg://", 1)

    @property
    def submission_bucket(self) -> Bucket:
        return Bucket(self.submission_burst, self.submission_refill_seconds)

    @property
    def guest_bucket(self) -> Bucket:
        return Bucket(self.guest_burst, self.guest_refill_seconds)

    @property
    def login_bucket(self) -> Bucket:
        return Bucket(self.login_burst, self.login_refill_seconds)

    @property
    def cell_bucket(self) -> Bucket:
        return Bucket(self.cell_burst, self.cell_refill_seconds)
