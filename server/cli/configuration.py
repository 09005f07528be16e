"""Settings for a command: a malformed one is told in words, with its variable's name."""

from typing import Any

from pydantic import ValidationError

from server.base.settings import Settings
from server.cli import CannotRun


def read_settings(**values: Any) -> Settings:
    """The environment's settings; `values` that are not None replace them."""
    try:
        return Settings(**{name: value for name, value in values.items() if value is not None})
    except ValidationError as error:
        faults = "".join(f"\n  BALISE_{str(one['loc'][0]).upper()} : {one['msg']}" for one in error.errors())
        raise CannotRun(f"réglages refusés :{faults}") from error
