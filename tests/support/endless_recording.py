"""Records until it is killed: python endless_recording.py FILE COUNTS ROWS PAUSE.

COUNTS is a file of one integer that always tells how many rows were handed to the recording.
"""

import sys
import time

import numpy as np
from recordings import CHANNELS, HEADER, McapSink


def rows(first, count):
    """Row number k holds k in every column."""
    number = np.arange(first, first + count)
    return number * 0.01, np.repeat(number[:, np.newaxis], 3, axis=1)


if __name__ == "__main__":
    path, counts, batch, pause = sys.argv[1], sys.argv[2], int(sys.argv[3]), float(sys.argv[4])
    done = np.memmap(counts, np.int64, "w+", shape=(1,))
    sink = McapSink(path, HEADER, CHANNELS)
    while True:
        sink.write("/contact/0", *rows(int(done[0]), batch))
        done[0] += batch
        time.sleep(pause)
