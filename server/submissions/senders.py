"""In whose turn a submission is graded."""

from ipaddress import IPv6Address, ip_address, ip_network

from server.identity.models import Account
from server.queue.port import Sender

#: Who goes first. Members of a class are to stand here, before other accounts.
MEMBER_RANK, GUEST_RANK = 0, 1
#: The bits of an IPv6 address that tell one subscriber from another; the others each machine chooses as it likes.
SUBSCRIBER = 64


def sender_of(account: Account, address: str) -> Sender:
    """An account has turns of its own. Anybody may become as many guests as they like: these share their address's."""
    name, network = str(account.id), network_of(address)
    if account.is_guest:
        return Sender(name, network, line=network, rank=GUEST_RANK)
    return Sender(name, network, line=name, rank=MEMBER_RANK)


def network_of(address: str) -> str:
    """What one subscriber has: an IPv4 address, or the network of an IPv6 one. Anything else stays as it is."""
    try:
        read = ip_address(address)
    except ValueError:
        return address
    if not isinstance(read, IPv6Address):
        return str(read)
    mapped = read.ipv4_mapped
    return str(ip_network((read.packed, SUBSCRIBER), strict=False) if mapped is None else mapped)
