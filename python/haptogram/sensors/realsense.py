# SPDX-License-Identifier: Apache-2.0
"""The program haptogram-realsense: Intel RealSense cameras, or recordings of them, to `haptogram live --from depth-pipe:-`."""
import argparse
import math
import queue
import sys
import threading
import time
import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ..cli import Parser, whole
from ..errors import ErrorCode, HaptogramError, bad_input, device_error
from .depth_pipe import Camera, DepthPipe, Pose, Vector
from ..program import exit_code_of
from .together import Frame, Shot, Together

QUIET_S = 1.0  # without a picture, after which a camera is said to be silent, and is started again
Frames = queue.SimpleQueue[tuple[int, Frame | None]]  # None: the recording has ended


def library() -> Any:
    try:
        import pyrealsense2  # 13 MB that nothing else needs
    except ImportError as error:
        raise HaptogramError(ErrorCode.USAGE, "pyrealsense2", f"{error}; pip install 'haptogram[realsense]'") from error
    return pyrealsense2


class Times:
    """Times of exposure by the machine's clock. The camera's own clock tells how frames follow each other; where it begins, and how far
    it has gone away from the machine's, follows from when they arrive."""

    def __init__(self, period_s: float) -> None:
        self._period_s, self._offset_s = period_s, math.inf

    def of(self, stamp_s: float, arrived_s: float) -> float:
        if not 0 <= arrived_s - (stamp_s + self._offset_s) <= self._period_s:
            self._offset_s = arrived_s - stamp_s
        return stamp_s + self._offset_s


class Source:
    """A camera, or a recording in its place."""

    def __init__(self, rs: Any, options: argparse.Namespace, pose: Pose, serial: str, recording: str) -> None:
        self._rs, self.pose, self.name = rs, pose, recording or f"camera {serial}"
        self._config = rs.config()
        if recording:
            self._config.enable_device_from_file(recording, False)
        else:
            self._config.enable_device(serial)
            self._config.enable_stream(rs.stream.depth, options.width, options.height, rs.format.z16, options.rate)
        self._pipeline = rs.pipeline()
        self._rate_hz: float = options.rate
        try:
            self._profile = self._pipeline.start(self._config)
        except RuntimeError as error:
            raise device_error(self.name, f"cannot be started: {error}; `rs-enumerate-devices` lists what a camera can do") from error
        self._device = self._profile.get_device()

    @property
    def serial(self) -> str:
        return str(self._device.get_info(self._rs.camera_info.serial_number))

    @property
    def rate_hz(self) -> float:
        return float(self._stream().fps())

    def camera(self) -> Camera:
        inside = self._stream().get_intrinsics()
        if any(abs(value) > 1e-9 for value in inside.coeffs):
            raise bad_input(self.name, f"its pictures are distorted ({inside}); only cameras that correct it themselves are understood")
        sensor = self._device.first_depth_sensor()
        baseline = self._rs.option.stereo_baseline
        more = {"baseline_mm": sensor.get_option(baseline)} if sensor.supports(baseline) else {}
        # It is kept as a float: 0.001 comes as 0.0010000000474974513.
        unit_mm = float(f"{1e3 * sensor.get_depth_scale():.7g}")
        return Camera(inside.width, inside.height, (inside.fx, inside.fy), (inside.ppx, inside.ppy), unit_mm, self.pose, **more)

    def run(self, place: int, frames: Frames) -> None:
        """Gives frames until the recording ends; of a camera, for ever."""
        times, last_s, said = Times(1 / self.rate_hz), time.monotonic(), False
        while True:
            ok, taken = self._pipeline.try_wait_for_frames(200)
            now_s = time.monotonic()
            depth = taken.get_depth_frame() if ok else None
            if depth:
                if said:
                    print(f"haptogram-realsense: {self.name}: gives pictures again", file=sys.stderr)
                last_s, said = now_s, False
                time_s = times.of(depth.get_timestamp() * 1e-3, now_s)
                frames.put((place, Frame(depth.get_frame_number(), time_s, now_s, bytes(depth.get_data()))))
            elif self._device.is_playback():
                if self._device.as_playback().current_status() == self._rs.playback_status.stopped:
                    frames.put((place, None))
                    return
            elif now_s - last_s > QUIET_S:
                if not said:
                    print(f"haptogram-realsense: {self.name}: gives no pictures; is it plugged in?", file=sys.stderr)
                last_s, said = now_s, True
                self._restart()

    def _restart(self) -> None:
        try:
            self._pipeline.stop()
        except RuntimeError:
            pass  # it was not started again the last time
        try:
            self._pipeline.start(self._config)
        except RuntimeError:
            pass  # it is still away

    def _stream(self) -> Any:
        return self._profile.get_stream(self._rs.stream.depth).as_video_stream_profile()


def poses(path: str) -> dict[str, Pose]:
    """Poses by serial numbers, in the file's order."""
    try:
        table = tomllib.loads(Path(path).read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise bad_input(path, f"cannot be read: {error}") from error
    found: dict[str, Pose] = {}
    entries = table.get("camera")
    if not isinstance(entries, list) or not entries:
        raise bad_input(path, "there is no camera; expected a table [[camera]] for each, with serial, position_mm, right and forward")
    for i, entry in enumerate(entries):
        where = f"{path}: camera {i + 1}"
        if not isinstance(entry, dict) or set(entry) != {"serial", "position_mm", "right", "forward"}:
            raise bad_input(where, "expected serial, position_mm, right and forward")
        if not isinstance(entry["serial"], str) or entry["serial"] in found:
            raise bad_input(where, f"serial must be a text in quotes that no other camera has, found {entry['serial']!r}")
        vectors = {key: _vector(entry[key], f"{where}: {key}") for key in ("position_mm", "right", "forward")}
        found[entry["serial"]] = Pose(**vectors)
    return found


def _vector(value: object, where: str) -> Vector:
    if not isinstance(value, list) or len(value) != 3 or not all(isinstance(part, int | float) and math.isfinite(part) for part in value):
        raise bad_input(where, f"found {value!r}, expected three numbers")
    return (float(value[0]), float(value[1]), float(value[2]))


def open_sources(rs: Any, options: argparse.Namespace) -> list[Source]:
    """Those that the poses name, or the only one that there is, in the array's middle, looking up."""
    known = poses(options.poses) if options.poses else {}
    if options.recording:
        opened = [Source(rs, options, Pose(), "", path) for path in options.recording]
        by_serial = {source.serial: source for source in opened}
        if len(by_serial) < len(opened):
            raise bad_input(options.recording[0], "two of the recordings are of the same camera")
        present = list(by_serial)
    else:
        present = [str(device.get_info(rs.camera_info.serial_number)) for device in rs.context().query_devices()]
    if not present:
        raise device_error("camera", "no RealSense camera is connected; --recording plays a file")
    if not known and len(present) > 1:
        raise HaptogramError(ErrorCode.USAGE, "--poses", f"there are {len(present)} cameras ({', '.join(present)}); name a file that says where each is")
    missing = [serial for serial in known if serial not in present]
    if missing:
        raise device_error(options.poses, f"camera {missing[0]} is not there; there are {', '.join(present)}")
    wanted = known or {present[0]: Pose()}
    if options.recording:
        for serial, pose in wanted.items():
            by_serial[serial].pose = pose
        return [by_serial[serial] for serial in wanted]
    return [Source(rs, options, pose, serial, "") for serial, pose in wanted.items()]


def send(sources: Sequence[Source], pipe: DepthPipe, rate_hz: float) -> None:
    def write(shots: Sequence[Shot]) -> None:
        for shot in shots:
            pipe.write(shot.number, shot.time_s, [None if one is None else one.picture for one in shot.frames])

    frames: Frames = queue.SimpleQueue()
    for place, source in enumerate(sources):
        threading.Thread(target=source.run, args=(place, frames), daemon=True).start()
    together, running = Together(len(sources), rate_hz), len(sources)
    while running:
        try:
            place, frame = frames.get(timeout=0.1 / rate_hz)
        except queue.Empty:
            shots = together.due(time.monotonic())
        else:
            running -= frame is None
            shots = together.add(place, frame) if frame else together.due(time.monotonic())
        write(shots)
    write(together.due(math.inf))


def parser() -> Parser:
    top = Parser(prog="haptogram-realsense", description=__doc__, epilog="Exit codes: 0 ok, 2 usage, 3 bad input, 4 camera.")
    top.add_argument("--poses", metavar="FILE", help="TOML: where each camera is (default: the only one, in the array's middle, looking up)")
    top.add_argument("--recording", metavar="FILE", action="append", help="of the library's own, played in place of a camera; may be repeated")
    top.add_argument("--width", type=whole(1, 65535), default=848, help="of cameras' pictures, pixels (848)")
    top.add_argument("--height", type=whole(1, 65535), default=480, help="(480)")
    top.add_argument("--rate", type=whole(1, 1000), default=30, help="pictures a second (30)")
    top.add_argument("--list", action="store_true", help="print serial numbers and names of the cameras that are connected")
    return top


def work() -> None:
    options = parser().parse_args()
    rs = library()
    if options.list:
        for device in rs.context().query_devices():
            print(device.get_info(rs.camera_info.serial_number), device.get_info(rs.camera_info.name))
        sys.stdout.flush()
        return
    if sys.stdout.isatty():
        raise HaptogramError(ErrorCode.USAGE, "standard output", "these are pictures; pipe them: haptogram-realsense | haptogram live --from depth-pipe:-")
    sources = open_sources(rs, options)
    rate_hz = sources[0].rate_hz
    send(sources, DepthPipe(sys.stdout.buffer, [source.camera() for source in sources], rate_hz), rate_hz)


def main() -> int:
    return exit_code_of("haptogram-realsense", work, interrupted=0)


if __name__ == "__main__":
    sys.exit(main())
