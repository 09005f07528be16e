"""In whose turn a submission is graded."""

from server.identity.models import Account
from server.queue.port import Sender

#: Who goes first. Members of a class are to stand here, before other accounts.
MEMBER_RANK, GUEST_RANK = 0, 1


def sender_of(account: Account, address: str) -> Sender:
    """An account has turns of its own. Anybody may become as many guests as they like: these share their address's.

    `address` is what the limits count as one visitor: see `server.base.request.client_address`.
    """
    name = str(account.id)
    if account.is_guest:
        return Sender(name, address, line=address, rank=GUEST_RANK)
    return Sender(name, address, line=name, rank=MEMBER_RANK)
