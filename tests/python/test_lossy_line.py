# SPDX-License-Identifier: Apache-2.0
"""A line that drops and damages bytes, both ways, between a client and a virtual board."""
import contextlib
import json
import os
import random
import select
import termios
import threading
import tty

import processes
import pytest
from haptogram import Client

ONE_IN = 800  # bytes


@contextlib.contextmanager
def lossy(port, seed):
    """A pseudo-terminal that passes on to `port` what survives."""
    ours, theirs = os.openpty()
    far = os.open(port, os.O_RDWR | os.O_NOCTTY)
    for descriptor in (theirs, far):
        tty.setraw(descriptor)
    settings = termios.tcgetattr(far)
    settings[4] = settings[5] = termios.B1000000
    termios.tcsetattr(far, termios.TCSANOW, settings)
    generator, ended, harm = random.Random(seed), threading.Event(), {"dropped": 0, "damaged": 0}

    def survive(data):
        out = bytearray()
        for byte in data:
            fate = generator.randrange(2 * ONE_IN)
            harm["dropped"] += fate == 0
            harm["damaged"] += fate == 1
            if fate:
                out.append(byte ^ generator.randrange(1, 256) if fate == 1 else byte)
        return bytes(out)

    def pass_on():
        while not ended.is_set():
            for source in select.select([ours, far], [], [], 0.05)[0]:
                os.write(far if source == ours else ours, survive(os.read(source, 4096)))

    thread = threading.Thread(target=pass_on)
    thread.start()
    try:
        yield os.ttyname(theirs), harm
    finally:
        ended.set()
        thread.join()
        for descriptor in (ours, theirs, far):
            os.close(descriptor)


@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.deep)])
def test_an_upload_arrives_whole(folder, image, seed):
    with processes.virtual_board(folder):
        with lossy(str(folder / "port"), seed) as (port, harm), Client.open(port) as client:
            client.upload(image)
            client.compare(image)
            assert client.download() == image
            assert harm["dropped"] and harm["damaged"] and client.retransmissions
        assert "read back and equal" in processes.haptogram(folder, "upload", "image.hex", "--port", "port", "--verify")


@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.deep)])
def test_an_upload_of_the_program_arrives_whole(folder, image, seed):
    """The other client on the same line."""
    with processes.virtual_board(folder):
        with lossy(str(folder / "port"), seed) as (port, harm):
            told = json.loads(processes.haptogram(folder, "upload", "image.hex", "--port", port, "--baud", "1000000", "--verify", "--json"))
            assert harm["dropped"] and harm["damaged"] and told["retransmissions"]
        with Client.open(str(folder / "port")) as client:
            client.compare(image)
            assert client.download() == image
