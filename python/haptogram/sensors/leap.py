# SPDX-License-Identifier: Apache-2.0
"""The program haptogram-leap: hands of a Leap's tracking service to `haptogram live --from leap-pipe:-`, a message a line."""
import asyncio
import json
import sys
from typing import Any

from ..cli import Parser
from ..errors import ErrorCode, HaptogramError, bad_input, device_error
from ..program import exit_code_of

URL = "ws://127.0.0.1:6437/v6.json"
PROTOCOL = 6


def library() -> Any:
    try:
        import websockets
    except ImportError as error:
        raise HaptogramError(ErrorCode.USAGE, "websockets", f"{error}; pip install 'haptogram[leap]'") from error
    return websockets


def line_of(message: str | bytes, url: str) -> bytes:
    """The message in one line."""
    try:
        parsed = json.loads(message)
    except ValueError as error:
        raise bad_input(url, f"found {message[:40]!r}, expected JSON: {error}") from error
    return json.dumps(parsed, separators=(",", ":")).encode() + b"\n"


def require_protocol(message: str | bytes, url: str) -> None:
    try:
        version = json.loads(message)["version"]
    except (ValueError, TypeError, KeyError) as error:
        raise bad_input(url, f"the first message is {message[:40]!r}, expected the service's version: this is no Leap service") from error
    if version != PROTOCOL:
        raise device_error(url, f"the service speaks protocol {version}, expected {PROTOCOL}")


async def listen(url: str) -> None:
    websockets = library()
    try:
        socket = await websockets.connect(url)
    except (OSError, websockets.WebSocketException) as error:
        raise device_error(url, f"no tracking service answers ({error}); before version 5 it must allow web apps, from 5 on start UltraleapTrackingWebSocket") from error
    try:
        require_protocol(await socket.recv(), url)
        await socket.send(json.dumps({"background": True}))  # frames come although this program has no window
        async for message in socket:
            sys.stdout.buffer.write(line_of(message, url))
            sys.stdout.buffer.flush()
    except websockets.ConnectionClosed:
        pass
    finally:
        await socket.close()
    raise device_error(url, "the tracking service has closed the connection")


def main() -> int:
    top = Parser(prog="haptogram-leap", description=__doc__, epilog="Exit codes: 0 ok, 2 usage, 3 bad input, 4 tracking service.")
    top.add_argument("--url", default=URL, help=f"of the service's WebSocket ({URL})")
    return exit_code_of("haptogram-leap", lambda: asyncio.run(listen(top.parse_args().url)), interrupted=0)


if __name__ == "__main__":
    sys.exit(main())
