"""What routes ask of this room: the boards that are watched."""

from typing import Annotated

from fastapi import Depends

from server.base.app_services import provided
from server.board.live import LiveBoards

LiveBoardsOf = Annotated[LiveBoards, Depends(provided(LiveBoards))]
