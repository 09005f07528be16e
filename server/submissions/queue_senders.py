"""The sender, flow and rank under which a submission is queued."""

from server.identity.models import Account
from server.queue.interfaces import Sender

#: Lower ranks are graded first.
MEMBER_RANK, ACCOUNT_RANK, GUEST_RANK = 0, 1, 2


def sender_of_account(account: Account, address: str, *, member: bool = False) -> Sender:
    """Return the queue sender of an account: an account has a flow of its own, guests share their address's.

    Anybody may become any number of guests, hence the shared flow. `address` counts as one visitor in the rate limits
    (`server.base.request.client_address`). `member`: of a class, let in by a teacher or a code. Guests of classes and
    other guests of an address have two flows.
    """
    name = str(account.id)
    rank = MEMBER_RANK if member else GUEST_RANK if account.is_guest else ACCOUNT_RANK
    flow = name if not account.is_guest else f"{address} (classe)" if member else address
    return Sender(name, address, flow=flow, rank=rank)
