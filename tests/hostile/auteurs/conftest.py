"""The studio of `tests/studio`, for authors who mean harm."""

from tests.studio.conftest import studio

__all__ = ["studio"]
