"""What an exercise asks for is nowhere in the process that its programs run in."""

from server.sandbox import Kit, Sandbox

SOURCE = b"""
import gc, sys
import trousse

def vue():
    noms = {getattr(o, "__name__", "") for o in gc.get_objects() if callable(o)}
    return ["lancer" in noms, "lancer" in globals(), hasattr(trousse, "lancer"), hasattr(trousse, "configurer"), PORTEE]
"""
KIT = """
__all__ = ["PORTEE", "lancer"]
def _aide(x):
    return x
def configurer(portee=3.0, seed=None):
    def lancer(x):
        return _aide(x)
    return {"PORTEE": portee, "lancer": lancer}
globals().update(configurer())
"""


def test_what_is_left_out_is_nowhere() -> None:
    with Sandbox({"trousse": KIT}) as sandbox:
        with sandbox.open(SOURCE, kit=Kit("trousse", {"portee": 2.0})) as session:
            assert session.call("vue").value == [True, True, True, True, 2.0]
        with sandbox.open(SOURCE, kit=Kit("trousse", {"portee": 2.0}, ("lancer",))) as session:
            assert session.call("vue").value == [False, False, False, False, 2.0]
