# SPDX-License-Identifier: Apache-2.0
"""Recordings of RealSense cameras, made by the library itself from a camera that exists in software."""
import time

import numpy as np
import pyrealsense2 as rs

RATE = 30


def record(path, serial, pictures, intrinsics, unit_m=0.000125, first_number=1, start_ms=1000.0, wait_s=0.005):
    """A recording of these pictures, arrays of counts, at 30 Hz. `intrinsics`: fx, fy, cx, cy."""
    height, width = pictures[0].shape
    device = rs.software_device()
    device.register_info(rs.camera_info.serial_number, serial)
    device.register_info(rs.camera_info.name, "of software")
    sensor = device.add_sensor("Stereo Module")
    sensor.add_read_only_option(rs.option.depth_units, unit_m)
    inside = rs.intrinsics()
    inside.width, inside.height = width, height
    inside.fx, inside.fy, inside.ppx, inside.ppy = intrinsics
    inside.model, inside.coeffs = rs.distortion.brown_conrady, [0] * 5
    stream = rs.video_stream()
    stream.type, stream.index, stream.uid, stream.fmt, stream.bpp = rs.stream.depth, 0, 0, rs.format.z16, 2
    stream.width, stream.height, stream.fps, stream.intrinsics = width, height, RATE, inside
    profile = sensor.add_video_stream(stream, True).as_video_stream_profile()
    recorder = rs.recorder(str(path), device)
    recorded = recorder.query_sensors()[0]
    queue = rs.frame_queue(len(pictures) + 1)
    recorded.open(recorded.get_stream_profiles()[0])
    recorded.start(queue)
    for i, picture in enumerate(pictures):
        frame = rs.software_video_frame()
        frame.pixels, frame.stride, frame.bpp = np.ascontiguousarray(picture, np.uint16), 2 * width, 2
        frame.timestamp, frame.domain = start_ms + 1000 * i / RATE, rs.timestamp_domain.hardware_clock
        frame.frame_number, frame.profile, frame.depth_units = first_number + i, profile, unit_m
        sensor.on_video_frame(frame)
        queue.wait_for_frame(60000)
        time.sleep(wait_s)
    recorded.stop()
    recorded.close()
