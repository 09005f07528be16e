"""Values of the wire: null, bool, int, float, complex, str, array of a listed dtype, tuple, list, dict with str keys.

`encode` runs among a student's objects and turns what looks like one of these into one of these. `decode` runs in the
trusted process on bytes that may be hostile: it yields exact base types, or raises Malformed; it allocates nothing that
the bytes do not fill.
"""

from .decoder import decode, decode_counted
from .encoder import encode, encode_columns, encode_returned
from .wire_values import DTYPES, Array, MalformedValue, TooManyItems, UnsendableValue, Value, ValueLimits, ValueTooBig

__all__ = [
    "DTYPES",
    "Array",
    "MalformedValue",
    "TooManyItems",
    "UnsendableValue",
    "Value",
    "ValueLimits",
    "ValueTooBig",
    "decode",
    "decode_counted",
    "encode",
    "encode_columns",
    "encode_returned",
]
