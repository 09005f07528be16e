"""The sandboxes that the tests of the room use."""

from tests.sandbox.conftest import alone, fault_of, kit, sandbox, without

__all__ = ["alone", "fault_of", "kit", "sandbox", "without"]
