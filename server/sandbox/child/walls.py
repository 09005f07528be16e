"""The names of the walls: each can be left down, to probe and to test the walls themselves."""

from __future__ import annotations

NAMESPACES = ("user", "pid", "view", "network", "ipc", "uts")
WALLS = frozenset(
    {
        *NAMESPACES,
        *("landlock", "seccomp", "rlimits", "cgroup"),
        *("identity", "capabilities", "dumpable", "environment", "descriptors"),
    }
)
