# left: lost
import builtins, codecs, inspect, time, zlib
import numpy as np
def dit(*_, **__):
    raise SystemExit("touché")
def suivre():
    garde = dict(vars(builtins))
    for nom in ("len", "list", "type", "id", "isinstance", "min", "max", "map", "repr", "tuple", "any", "dict", "set"):
        setattr(builtins, nom, dit)
    zlib.crc32 = time.thread_time = inspect.CO_OPTIMIZED = dit
    np.asarray = np.ndarray = np.generic = np.array = dit
    x = [1]
    y = {"a": x}
    vars(builtins).update(garde)
    return "rien"
