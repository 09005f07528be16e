"""A number of bytes as people read it."""

NO_BREAK = "\u00a0"
UNITS = ((1 << 30, "Gio"), (1 << 20, "Mio"), (1 << 10, "Kio"))


def size(count: float) -> str:
    """« 64 Kio », « 1,5 Mio », « 1 octet »."""
    for unit, name in UNITS:
        if count >= unit:
            return f"{count / unit:.2f}".rstrip("0").rstrip(".").replace(".", ",") + NO_BREAK + name
    return f"{count:.0f}{NO_BREAK}octet{'s' if count >= 2 else ''}"
