"""Une date et une durée, en secondes et nanosecondes."""

from champs import INT32, UINT32, Message


class Time(Message):
    champs = {"sec": INT32, "nanosec": UINT32}


class Duration(Message):
    champs = {"sec": INT32, "nanosec": UINT32}
