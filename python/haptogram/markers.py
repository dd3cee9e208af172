# SPDX-License-Identifier: Apache-2.0
"""Marks what happens on a stream of the Lab Streaming Layer, beside the EEG, EMG or motion that a laboratory records. It takes
`pip install 'haptogram[lsl]'`."""
import json
import time


class Markers:
    """A stream named haptogram, of the type Markers. Each marker is a line of JSON."""

    def __init__(self, source: str) -> None:
        """`source` tells this stream from others, also after it has begun anew."""
        import pylsl

        # Both clocks never stop or go back; they are read together more than once because the scheduler may come between.
        self._ahead_s = min((pylsl.local_clock() - time.monotonic() for _ in range(20)), key=abs)
        self._outlet = pylsl.StreamOutlet(pylsl.StreamInfo("haptogram", "Markers", 1, pylsl.IRREGULAR_RATE, pylsl.cf_string, source))

    def wait(self) -> None:
        """Until somebody receives the stream: what is marked before that is lost."""
        while not self._outlet.wait_for_consumers(1.0):
            pass

    def close(self) -> None:
        """The layer's own threads send what was marked, and do not tell when they have: the last markers of a short session were lost."""
        time.sleep(1.0)

    def mark(self, kind: str, at_s: float, **more: object) -> None:
        """What happened at this time.monotonic(), which may have been a while ago."""
        self._outlet.push_sample([json.dumps({"kind": kind, **more})], at_s + self._ahead_s)


def no_mark(kind: str, at_s: float, **more: object) -> None:
    """Where nobody asked for markers."""
