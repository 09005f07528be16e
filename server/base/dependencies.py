"""The settings, as routes ask for them."""

from typing import Annotated

from fastapi import Depends

from server.base.provided import provided
from server.base.settings import Settings

SettingsOf = Annotated[Settings, Depends(provided(Settings))]
