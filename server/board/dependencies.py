"""Dependencies of routes that stream boards."""

from typing import Annotated

from fastapi import Depends

from server.base.app_services import app_service
from server.board.live import LiveClassViews

LiveBoardsOf = Annotated[LiveClassViews, Depends(app_service(LiveClassViews))]
