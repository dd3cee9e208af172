# SPDX-License-Identifier: Apache-2.0
"""The service for other programs, as programs in other languages meet it: a WebSocket and OSC datagrams."""
import asyncio
import contextlib
import fcntl
import json
import os
import random
import re
import signal
import socket
import struct
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
import websockets
from messages import notice, program_said
from patience import also_in_time, until
from websockets.exceptions import InvalidStatusCode

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = Path(os.environ.get("HAPTOGRAM_PROGRAM", ROOT / "build/release/host/cli/haptogram")).resolve()
PROJECT = 'format = "haptogram-project-1"\nboard = "tile-100-wide"\narray = "tile-10x10"\nimage = "foci"\npoints = 20\n[[shape]]\nkind = "circle"\ndiameter_mm = 40\n'


class connect:
    """A WebSocket whose calls wait."""

    def __init__(self, address, additional_headers=None, subprotocols=None):
        self.loop = asyncio.new_event_loop()
        self.socket = self.loop.run_until_complete(self.open(address, additional_headers, subprotocols))

    @staticmethod
    async def open(address, headers, subprotocols):
        return await websockets.connect(address, extra_headers=headers, subprotocols=subprotocols, ping_interval=None)

    def send(self, message):
        self.loop.run_until_complete(self.socket.send(message))

    def recv(self, timeout):
        return self.loop.run_until_complete(asyncio.wait_for(self.socket.recv(), timeout))

    def close(self):
        self.loop.run_until_complete(self.socket.close())


def free_port():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as s:
        s.bind(("127.0.0.1", 0))
        return s.getsockname()[1]


class Service:
    def __init__(self, *options, port="reference:tile-100-wide", stderr=subprocess.DEVNULL):
        self.osc_port = free_port()
        self.process = subprocess.Popen([PROGRAM, "serve", "--port", port, "--osc", str(self.osc_port), "--json", *options],
                                        stdout=subprocess.PIPE, stderr=stderr, text=True)
        said = json.loads(self.process.stdout.readline())
        self.address, self.token = said["address"], said["token"]
        self.clients = []
        self.sender = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)

    def client(self):
        self.clients.append(Client(connect(self.address, additional_headers={"Authorization": f"Bearer {self.token}"})))
        return self.clients[-1]

    def osc(self, address, *numbers, sender=None):
        def text(s):
            return s.encode() + b"\0" * (4 - len(s) % 4)

        self.datagram(text(address) + text("," + "f" * len(numbers)) + struct.pack(f">{len(numbers)}f", *numbers), sender)

    def datagram(self, content, sender=None):
        (sender or self.sender).sendto(content, ("127.0.0.1", self.osc_port))

    def end(self):
        for client in self.clients:
            client.close()
        self.sender.close()
        self.process.terminate()
        assert self.process.wait(timeout=300) == 0


class Client:
    def __init__(self, socket):
        self.socket = socket

    def ask(self, do, **more):
        self.socket.send(json.dumps({"do": do, **more}))
        return json.loads(self.socket.recv(timeout=300))

    def ok(self, do, **more):
        said = self.ask(do, **more)
        assert said.get("ok") is True, said
        return said

    def fails(self, code, word, do, **more):
        error = self.ask(do, **more)["error"]
        assert error["code"] == code and word in error["message"], error

    def until(self, **wanted):
        def is_so():
            said = self.ok("status")
            return said if all(said[key] == value for key, value in wanted.items()) else None

        return until(is_so, f"{wanted}", every=0.05)

    def close(self):
        self.socket.close()


@pytest.fixture
def service():
    running = Service()
    yield running
    running.end()


def test_a_sequence_and_a_live_focus(service):
    client = service.client()
    assert client.ok("identify")["channels"] == 100
    assert client.ok("compile", project=PROJECT, id=7)["id"] == 7
    client.ok("play", loops=3)
    client.until(enabled=True)
    client.until(enabled=False, busy=False)
    client.ok("live", am="sine:200")
    for k in range(100):
        client.socket.send(struct.pack("<4d", 1e-4 * k, 0.0, 0.15, 1.0))
    said = client.until(enabled=True, busy=True)
    client.ok("focus", at_m=[0.0, 0.01, 0.15], amplitude=0.5)
    client.ok("intensity", factor=0.5)
    until(lambda: client.ok("status")["foci_sent"] > said["foci_sent"], "more foci", every=0.05)
    client.ok("stop")
    client.until(enabled=False, busy=False)


def test_what_is_wrong_is_said(service):
    client = service.client()
    client.fails("bad_argument", "found 'fly'", "fly")
    client.fails("bad_argument", "at_m", "focus", at_m=[1, 2])
    client.fails("bad_input", "5", "focus", at_m=[5, 0, 0.1])
    client.fails("bad_argument", "amplitude", "focus", at_m=[0, 0, 0.1], amplitude="much")
    client.fails("bad_argument", "loops", "play", loops=-1)
    client.fails("bad_input", "Intel HEX", "image", hex="no image")
    client.fails("bad_argument", "value", "intensity", value=0.2)
    client.fails("bad_argument", "factor", "intensity")
    client.fails("bad_argument", "second", "live", second=0.5)
    client.fails("bad_argument", "found -1", "live", seconds=-1)
    client.fails("bad_argument", "amplitud", "focus", at_m=[0, 0, 0.15], amplitud=0.1)
    for file in ("csv:/etc/hostname", "wav:none"):
        client.fails("bad_argument", "am: names the file", "live", am=file)
        client.fails("bad_argument", "am: names the file", "play", am=file)
        client.fails("bad_argument", "names the file", "compile", project=PROJECT.replace("points", f'am = "{file}"\npoints'))
    client.fails("bad_argument", "names the file 'mine.toml'", "compile", project=PROJECT.replace("tile-10x10", "mine.toml"))
    assert not client.ok("status")["busy"]
    client.fails("bad_argument", "built-in", "compile", project=PROJECT + '[[shape]]\nfile = "/etc/passwd"\n')
    client.fails("bad_argument", "shipped", "compile", project=PROJECT.replace("tile-10x10", "/etc/passwd"))
    for wrong in ("", "[]", "{", '{"do": 3}', "\u0000", "9" * 10000):
        client.socket.send(wrong)
        assert "error" in json.loads(client.socket.recv(timeout=300))
    client.socket.send(b"\x00" * 31)
    assert "32" in json.loads(client.socket.recv(timeout=300))["error"]["message"]


def test_the_page_of_messages_is_what_is_taken(service):
    page = json.loads((ROOT / "extras/serve/asyncapi.json").read_text(encoding="utf-8"))
    verbs = [name for name in page["components"]["messages"] if name not in ("done", "failure")]
    client = service.client()
    taken = client.ask("?")["error"]["message"].split("expected one of ")[1].split(", ")
    assert taken == verbs
    for name in verbs:
        payload = page["components"]["messages"][name]["payload"]
        assert ("error" if payload["required"][1:] else "ok") in client.ask(name), name
        refused = client.ask(name, id=3, amplitud=0.1)
        keys = [key for key in payload["properties"] if key not in ("do", "id")]
        assert refused["id"] == 3 and refused["error"]["message"].endswith(", ".join(keys) or "no more than do and id"), refused
        client.ask("leave")


def test_a_port_that_is_taken_is_named(service):
    taken = service.address.rsplit(":", 1)[1]
    done = subprocess.run([PROGRAM, "serve", "--port", "reference:tile-100-wide", "--listen", taken], capture_output=True, text=True, timeout=300)
    assert done.returncode == 2
    program_said(done.returncode, done.stderr)


def test_one_drives_and_everybody_may_stop_it(service):
    first, second = service.client(), service.client()
    first.ok("compile", project=PROJECT)
    first.ok("live")
    first.until(enabled=True)
    second.fails("device", "another client", "live")
    second.fails("device", "another client", "stop")
    assert second.ok("status")["owned"]
    second.ok("shut_off")
    second.until(enabled=False)
    first.ok("live")
    first.until(enabled=True)
    first.close()  # and the outputs go off
    second.until(enabled=False, owned=False)
    second.ok("live")
    second.ok("leave")
    second.until(enabled=False, owned=False)


@contextlib.contextmanager
def driven_by_osc(service):
    """Somebody who watches, and the state once a focus plays that came by OSC, whose sender is alive meanwhile."""
    client = service.client()
    client.ok("compile", project=PROJECT)
    client.ok("leave")
    over = threading.Event()

    def say_so():
        while not over.wait(0.1):
            service.osc("/haptogram/alive")

    sender = threading.Thread(target=say_so)
    sender.start()
    try:
        service.osc("/haptogram/focus", 0.0, 0.0, 0.15)
        service.osc("/haptogram/live")
        yield client, client.until(enabled=True, busy=True)
    finally:
        over.set()
        sender.join()


def test_osc(service):
    with driven_by_osc(service) as (client, before):
        service.osc("/haptogram/focus", 0.01, 0.0, 0.15, 0.5)
        client.fails("device", "another client", "live")
        service.osc("/haptogram/stop")
        client.until(enabled=False)
    client.until(owned=False)  # whose turn it was lapses
    client.ok("live")
    assert client.until(enabled=True)["connected"] and before["connected"]


def test_the_outputs_go_off_when_an_osc_sender_goes(service):
    with driven_by_osc(service) as (client, _):
        time.sleep(2)  # twice as long as it may be silent
        assert client.ok("status")["enabled"]
    client.until(enabled=False, busy=False, owned=False)
    client.ok("live")
    client.until(enabled=True)


def test_a_stranger_does_not_keep_alive_what_a_dead_osc_sender_played(service):
    with driven_by_osc(service) as (client, _):
        pass  # it is silent now
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as stranger:
        over = threading.Event()

        def say_so():
            while not over.wait(0.1):
                service.osc("/haptogram/alive", sender=stranger)

        sender = threading.Thread(target=say_so)
        sender.start()
        try:
            client.until(enabled=False, busy=False)
        finally:
            over.set()
            sender.join()


def test_what_a_board_that_is_away_is_asked_for_keeps_nobody_waiting(tmp_path):
    """Each play would wait for the board for 3 s: twenty of them for a minute."""
    board = subprocess.Popen([PROGRAM, "board", "run", "--model", "reference", "--board", "tile-100-wide", "--pty", tmp_path / "port"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
    try:
        until((tmp_path / "port").exists, "a port")
        service = Service(port=str(tmp_path / "port"))
        client = service.client()
        client.until(connected=True)
    finally:
        board.kill()
        board.communicate()
    client.until(connected=False)
    for _ in range(20):
        service.osc("/haptogram/play")
    begun = time.monotonic()
    for _ in range(5):
        client.ok("status")
    client.ask("shut_off")  # which the board cannot confirm
    assert time.monotonic() - begun < 30
    service.end()


def test_a_hung_client_that_drives_has_gone(service):
    watcher = service.client()
    code = (
        "import asyncio, json, sys, websockets\n"
        "async def run():\n"
        "    s = await websockets.connect(sys.argv[1], extra_headers={'Authorization': 'Bearer ' + sys.argv[2]}, ping_interval=None)\n"
        "    for ask in ({'do': 'compile', 'project': sys.argv[3]}, {'do': 'play', 'loops': 0}):\n"
        "        await s.send(json.dumps(ask))\n"
        "        assert json.loads(await s.recv())['ok']\n"
        "    print('plays', flush=True)\n"
        "    await asyncio.sleep(3600)\n"
        "asyncio.run(run())\n"
    )
    owner = subprocess.Popen([sys.executable, "-c", code, service.address, service.token, PROJECT], stdout=subprocess.PIPE, text=True)
    try:
        assert owner.stdout.readline() == "plays\n"
        watcher.until(enabled=True)
        owner.send_signal(signal.SIGSTOP)
        watcher.until(enabled=False, busy=False, owned=False)
    finally:
        owner.kill()
        owner.communicate()


def test_why_playing_has_ended_is_in_the_status(service):
    client = service.client()
    client.ok("live")  # there is no image of foci
    assert "foci" in client.until(busy=False)["failed"]
    client.ok("compile", project=PROJECT)
    client.ok("live")
    client.until(enabled=True, failed="")


@pytest.mark.parametrize("headers, status", [({}, 401), ({"Authorization": "Bearer no"}, 401), ({"Origin": "http://evil.example"}, 403)])
def test_strangers_stay_outside(service, headers, status):
    with pytest.raises(InvalidStatusCode) as refused:
        connect(service.address, additional_headers={"Authorization": f"Bearer {service.token}", **headers} if "Origin" in headers else headers)
    assert refused.value.status_code == status


def test_pages_of_a_site_that_was_named_are_let_in():
    service = Service("--origin", "http://localhost:8000")
    token = ["haptogram.1", f"token.{service.token}"]
    try:
        service.clients.append(Client(connect(service.address, {"Origin": "http://localhost:8000"}, token)))
        assert service.clients[0].socket.socket.subprotocol == "haptogram.1"
        assert service.clients[0].ok("status")["connected"]
        for origin, offered, status in [("http://localhost:8000", None, 401), ("http://localhost:8000", ["haptogram.1", "token.no"], 401),
                                        ("http://localhost:8000", token[1:], 401), ("http://localhost:80", token, 403), ("null", token, 403)]:
            with pytest.raises(InvalidStatusCode) as refused:
                connect(service.address, {"Origin": origin}, offered)
            assert refused.value.status_code == status
    finally:
        service.end()


def test_another_name_is_no_name_of_ours(service):
    port = int(service.address.rsplit(":", 1)[1])
    with socket.create_connection(("127.0.0.1", port), timeout=300) as s:
        s.sendall(f"GET / HTTP/1.1\r\nHost: evil.example:{port}\r\nAuthorization: Bearer {service.token}\r\n\r\n".encode())
        assert s.recv(100).startswith(b"HTTP/1.1 421")


@also_in_time
def test_half_open_strangers_do_not_keep_a_stop_away(service, figure, in_time):
    client = service.client()
    client.ok("compile", project=PROJECT)
    client.ok("live")
    port = int(service.address.rsplit(":", 1)[1])
    strangers = [socket.create_connection(("127.0.0.1", port)) for _ in range(40)]
    begin = time.monotonic()
    client.ok("shut_off")
    if in_time:
        figure("serve: a stop beside forty half-open strangers", time.monotonic() - begin, 0.2)
    begin = time.monotonic()
    assert service.client().ok("shut_off")  # and who comes after them is let in
    if in_time:
        figure("serve: who comes after them is let in", time.monotonic() - begin, 0.7)
    for s in strangers:
        s.close()
    silent = socket.create_connection(("127.0.0.1", port), timeout=300)
    assert silent.recv(1) == b"", "a stranger who says nothing is not waited for"


def test_too_many_requests_are_refused_but_a_stop_is_not(service):
    client = service.client()

    def answers(count, request):
        for _ in range(count):
            client.socket.send(request)
        return [json.loads(client.socket.recv(timeout=300)) for _ in range(count)]

    assert sum("ok" in answer for answer in answers(1000, '{"do": "status"}')) >= 200
    for verb in ("shut_off", "stop", "leave"):
        # Until there are too many of them, which takes a busy machine more; its name alone is no stop.
        until(lambda: any("error" in answer for answer in answers(300, '{"do": "status", "id": "shut_off"}')), "a refusal")
        assert client.ok(verb)


def test_what_waits_is_bounded_and_hurts_nobody_else(service):
    client, other = service.client(), service.client()
    with pytest.raises(websockets.exceptions.ConnectionClosed):
        for _ in range(9):  # each takes far longer to be refused than to be read
            client.socket.send(json.dumps({"do": "compile", "project": f"a = [{'1,' * (7 << 20)}]"}))
        while True:
            client.socket.recv(timeout=300)
    assert client.socket.socket.close_code == 1008 and "MiB of messages wait" in client.socket.socket.close_reason
    assert other.ok("status")["connected"]


def test_random_datagrams_and_messages_do_no_harm(service):
    """Ten thousand of each; the seed is shown, and HAPTOGRAM_SEED repeats it."""
    seed = int(os.environ.get("HAPTOGRAM_SEED", random.randrange(1 << 32)))
    print("seed", seed)
    rng = random.Random(seed)
    pieces = [b"/haptogram/focus\0\0\0\0", b",fff\0\0\0\0", b"#bundle\0", b"\0\0\0\0", b",b\0\0", b"\xff\xff\xff\xff", struct.pack(">f", 0.1)]
    for _ in range(10_000):
        service.datagram(b"".join(rng.choice(pieces) if rng.random() < 0.8 else rng.randbytes(rng.randrange(9)) for _ in range(rng.randrange(8))))
    client = service.client()
    words = ["{", "}", '"do"', ":", '"focus"', '"at_m"', "[1,2,3]", ",", "1e999", "null", '"compile"', '"project"', '"\\ud800"', "[" * 50]
    for k in range(10_000):
        if k % 150 == 149:
            client.close()
            client = service.client()
        if rng.random() < 0.9:
            client.socket.send("".join(rng.choice(words) for _ in range(rng.randrange(12))))
            client.socket.recv(timeout=300)
        else:
            client.socket.send(rng.randbytes(rng.randrange(31)))
    client.close()
    assert service.client().ok("status")["connected"]


def playing(service):
    """A client, whose image plays for ever."""
    client = service.client()
    client.ok("compile", project=PROJECT)
    client.ok("play", loops=0)
    client.until(enabled=True)
    return client


def test_a_strangers_datagrams_and_a_stderr_that_nobody_reads_hold_nothing_up():
    reading, writing = os.pipe()
    if hasattr(fcntl, "F_SETPIPE_SZ"):
        fcntl.fcntl(writing, fcntl.F_SETPIPE_SZ, 4096)
    service = Service(stderr=writing)
    os.close(writing)
    client = playing(service)
    name = b"/\x1b]0;title\x07\x9b" + b"A" * 60000  # more than the pipe holds
    for _ in range(30):
        service.datagram(name + b"\0" * (4 - len(name) % 4) + b",\0\0\0")
        service.datagram(b"bad" + b"A" * 50001)
    service.osc("/haptogram/stop")  # it is behind all of them
    client.until(enabled=False)
    service.end()
    said = os.read(reading, 1 << 20)
    os.close(reading)
    assert said.startswith(b"haptogram: a datagram from port ") and len(said) < 500
    assert b"\\x1b]0;title\\x07\\x9bAAA" in said and not set(said[:-1]) & set(range(32)) - {10}


def test_four_clients_at_once(service):
    """Ten minutes of it with HAPTOGRAM_SOAK=1."""
    seconds = 600 if os.environ.get("HAPTOGRAM_SOAK") else 3
    driver = service.client()
    driver.ok("compile", project=PROJECT)
    driver.ok("live")
    end, wrong = time.monotonic() + seconds, []

    def watch():
        try:
            client = service.client()
            while time.monotonic() < end:
                client.ok("status")
                time.sleep(0.02)
        except Exception as error:  # noqa: BLE001: told below
            wrong.append(error)

    watchers = [threading.Thread(target=watch) for _ in range(3)]
    for watcher in watchers:
        watcher.start()
    while time.monotonic() < end:
        driver.socket.send(struct.pack("<4d", random.uniform(-0.02, 0.02), 0.0, 0.15, 1.0))
        time.sleep(0.001)
    for watcher in watchers:
        watcher.join()
    said = driver.ok("status")
    assert not wrong and said["enabled"], said
    driver.ok("stop")


def test_its_end_turns_the_outputs_off(tmp_path):
    board = subprocess.Popen([PROGRAM, "board", "run", "--model", "reference", "--board", "tile-100-wide", "--pty", "board"], cwd=tmp_path,
                             stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    until(lambda: (tmp_path / "board").exists(), "the board's name")
    served = subprocess.Popen([PROGRAM, "serve", "--port", "board", "--no-token", "--json"], cwd=tmp_path, stdout=subprocess.PIPE, text=True)
    client = Client(connect(json.loads(served.stdout.readline())["address"]))
    client.ok("compile", project=PROJECT)
    client.ok("live")
    client.until(enabled=True)
    served.terminate()
    assert served.wait(timeout=300) == 0
    said = json.loads(subprocess.run([PROGRAM, "device", "status", "--port", "board", "--json"], cwd=tmp_path, capture_output=True, check=True).stdout)
    assert said["outputs"] == "off" and said["watchdog_trips"] == 0
    board.terminate()
    board.wait()


def test_a_bundle_for_later_is_done_at_once_and_told_of_once():
    reading, writing = os.pipe()
    service = Service(stderr=writing)
    os.close(writing)
    client = playing(service)
    alive = b"/haptogram/alive\0\0\0\0,\0\0\0"
    stop = b"/haptogram/stop\0,\0\0\0"

    def bundle(time, message):
        return b"#bundle\0" + struct.pack(">QI", time, len(message)) + message

    service.datagram(bundle(1, alive))  # at once
    for seconds in (3, 4):
        service.datagram(bundle((4_000_000_000 + seconds) << 32, alive))
    service.datagram(bundle(4_000_000_005 << 32, stop))
    client.until(enabled=False)
    service.end()
    said = os.read(reading, 1 << 20)
    os.close(reading)
    assert said.count(b"has a time tag") == 1
    notice(re.sub(rb"port \d+", b"port 1", next(line for line in said.splitlines() if b"time tag" in line)))
