"""Running a reader's cell, within rate and size limits."""

from starlette.concurrency import run_in_threadpool

from server.base.errors import InternalFailure, Overloaded
from server.base.settings import Settings
from server.base.validation import encode_bounded
from server.cells.supervisor import CellRunner
from server.classes import presence
from server.database import Database
from server.identity.models import Account
from server.limits import service as limits
from server.queue.interfaces import Sender
from server.submissions.queue_senders import sender_of_account

TOO_FAST = "Vous avez exécuté beaucoup de cellules en peu de temps : la prochaine est possible dans {seconds} s."


async def run_reader_cell(
    cells: CellRunner, database: Database, settings: Settings, account: Account, module: str, code: str, *, address: str
) -> bytes:
    """What the page gets, as JSON text. Raises Invalid, TooLarge, TooMany, Crowded or Failed."""
    encode_bounded(code, settings.code_bytes)
    key = f"cell:{account.id}"

    def take() -> Sender:
        with database.write() as db:
            limits.take_token(db, key, settings.cell_bucket, TOO_FAST)
            return sender_of_account(account, address, member=presence.is_active_member(db, account.id))

    def give_back() -> None:
        with database.write() as db:
            limits.give_back_token(db, key)

    sender = await run_in_threadpool(take)
    try:
        return await cells.run_cell(module, code, reader=str(account.id), flow=sender.flow, rank=sender.rank)
    except (Overloaded, InternalFailure):
        await run_in_threadpool(give_back)
        raise
