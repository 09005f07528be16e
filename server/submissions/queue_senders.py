"""In whose turn a submission is graded."""

from server.identity.models import Account
from server.queue.interfaces import Sender

#: Who goes first.
MEMBER_RANK, ACCOUNT_RANK, GUEST_RANK = 0, 1, 2


def queue_sender(account: Account, address: str, *, member: bool = False) -> Sender:
    """An account has turns of its own. Anybody may become as many guests as they like: these share their address's.

    `address` is what the limits count as one visitor: see `server.base.http.client_address`. `member`: of a class,
    which a teacher or a code has let in. Guests of classes and other guests of an address are two lines.
    """
    name = str(account.id)
    rank = MEMBER_RANK if member else GUEST_RANK if account.is_guest else ACCOUNT_RANK
    line = name if not account.is_guest else f"{address} (classe)" if member else address
    return Sender(name, address, flow=line, rank=rank)
