"""The modal amplitudes as joint states, which viewers plot without a layout."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from slipmode.rom.arrays import Floats
from slipmode.runner.recording.channels import NANOSECONDS, Channel

SCHEMA = f"""\
std_msgs/Header header
string[] name
float64[] position
float64[] velocity
float64[] effort
{"=" * 80}
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
{"=" * 80}
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
"""


class Overview:
    """Encodes the moduli of the modes as joint positions, thinned as the run gets longer.

    `modes` is the channel ``/modes``.
    """

    topic: ClassVar = "/overview/modes"

    def __init__(self, modes: Channel) -> None:
        self._columns = [k for k, name in enumerate(modes.names) if name.endswith("_abs")]
        fields = [modes.fields[k] for k in self._columns]
        self._empty = _joint_state([f"|{f.name[:-4]}| [{f.unit}]" for f in fields])
        self._seen = 0

    def encode(
        self, time_ns: NDArray[np.int64], rows: Floats
    ) -> tuple[NDArray[np.int64], NDArray[np.void]]:
        """Return times (kept,) [ns] and messages (kept,) of next samples of ``/modes``.

        The samples are given by times (n,) [ns] and values (n, n_fields).
        """
        number = np.arange(self._seen, self._seen + len(rows))
        self._seen += len(rows)
        # the first 4096 rows are kept, later one in 2, 4, 8... as the run gets so much longer
        doublings = np.frexp(number // 4096)[1]
        kept = number % (1 << doublings.astype(np.int64)) == 0
        messages = np.full(np.count_nonzero(kept), self._empty)
        messages["sec"], messages["nanosec"] = np.divmod(time_ns[kept], NANOSECONDS)
        messages["position"] = rows[kept][:, self._columns]
        return time_ns[kept], messages


def _joint_state(names: Sequence[str]) -> NDArray[np.void]:
    """Return a joint state of zero positions, without velocity and effort, shape ().

    It is in CDR, little-endian: every item is aligned to its size.
    """
    count = struct.pack("<I", len(names))
    texts = [f"{text}\0".encode() for text in ("", *names)]
    frame_id, *strings = (struct.pack("<I", len(data)) + data for data in texts)
    body = bytes(8)  # the stamp
    for part in (frame_id, count, *strings, count):
        body += bytes(-len(body) % 4) + part
    body += bytes(-len(body) % 8)
    stamp = [("encoding", "V4"), ("sec", "<i4"), ("nanosec", "<u4")]
    position = [("constant", f"V{len(body) - 8}"), ("position", "<f8", (len(names),))]
    layout = np.dtype([*stamp, *position, ("empty", "V8")])  # no velocity, no effort
    return np.frombuffer(b"\0\1\0\0" + body + bytes(8 * len(names) + 8), layout).reshape(())
