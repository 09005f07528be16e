"""What routes ask of this room: the boards that are watched."""

from typing import Annotated

from fastapi import Depends

from server.base.provided import provided
from server.board.live import LiveBoards

LiveBoardsOf = Annotated[LiveBoards, Depends(provided(LiveBoards))]
