"""Des durées, en nanosecondes entières."""

import builtin_interfaces.msg


class Duration:
    def __init__(self, *, seconds=0, nanoseconds=0):
        self._nanoseconds = int(seconds * 10**9) + int(nanoseconds)

    @property
    def nanoseconds(self):
        return self._nanoseconds

    def to_msg(self):
        secondes, reste = divmod(self._nanoseconds, 10**9)
        return builtin_interfaces.msg.Duration(sec=secondes, nanosec=reste)

    @classmethod
    def from_msg(cls, msg):
        return cls(seconds=msg.sec, nanoseconds=msg.nanosec)

    def __repr__(self):
        return f"Duration(nanoseconds={self._nanoseconds})"

    def _comparer(self, autre, comparaison):
        if not isinstance(autre, Duration):
            return NotImplemented
        return comparaison(self._nanoseconds, autre._nanoseconds)

    def __eq__(self, other):
        return self._comparer(other, lambda a, b: a == b)

    def __lt__(self, other):
        return self._comparer(other, lambda a, b: a < b)

    def __le__(self, other):
        return self._comparer(other, lambda a, b: a <= b)

    def __gt__(self, other):
        return self._comparer(other, lambda a, b: a > b)

    def __ge__(self, other):
        return self._comparer(other, lambda a, b: a >= b)

    def __hash__(self):
        return hash(self._nanoseconds)


class Infinite(Duration):
    """Une durée sans fin."""

    def __init__(self):
        super().__init__(nanoseconds=2**63 - 1)
