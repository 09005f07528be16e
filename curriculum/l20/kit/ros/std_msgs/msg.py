"""L'en-tête daté que portent les mesures, et des valeurs seules."""

from builtin_interfaces.msg import Time
from champs import BOOLEEN, DOUBLE, FLOAT, INT32, INT64, TEXTE, UINT8, Message


class Header(Message):
    champs = {"stamp": Time, "frame_id": TEXTE}


class Empty(Message):
    champs = {}


class Bool(Message):
    champs = {"data": BOOLEEN}


class String(Message):
    champs = {"data": TEXTE}


class Float32(Message):
    champs = {"data": FLOAT}


class Float64(Message):
    champs = {"data": DOUBLE}


class Int32(Message):
    champs = {"data": INT32}


class Int64(Message):
    champs = {"data": INT64}


class UInt8(Message):
    champs = {"data": UINT8}
