# SPDX-License-Identifier: Apache-2.0
# fmt: off
"""Written by tools/c_header.py from host/c/haptogram.h: its structs, and the types of its functions."""
from ctypes import POINTER, Structure, c_char_p, c_double, c_int, c_int32, c_size_t, c_uint8, c_uint16, c_uint32, c_uint64, c_void_p
from typing import Any

ABI = 1


class Project(Structure):
    _fields_ = [("size", c_uint32), ("toml", c_char_p), ("folder", c_char_p), ("shape_name", c_char_p), ("shape", c_void_p), ("shape_bytes", c_size_t), ("name", c_char_p), ("file", c_char_p), ("cancel", POINTER(c_int32))]


class Focus(Structure):
    _fields_ = [("x_m", c_double), ("y_m", c_double), ("z_m", c_double), ("amplitude", c_double)]


class Path(Structure):
    _fields_ = [("size", c_uint32), ("board", c_char_p), ("array", c_char_p), ("foci", POINTER(Focus)), ("periods", POINTER(c_uint32)), ("steps", c_size_t), ("each", c_uint32), ("loops", c_uint16), ("board_computes", c_int32), ("marks", POINTER(c_uint8))]


class ArraySource(Structure):
    _fields_ = [("size", c_uint32), ("name", c_char_p), ("like", c_void_p), ("transducer", c_char_p), ("positions_m", POINTER(c_double)), ("normals", POINTER(c_double)), ("elements", c_size_t), ("seen_from", POINTER(c_double))]


class PosedArray(Structure):
    _fields_ = [("array", c_void_p), ("pose", POINTER(c_double))]


class Source(Structure):
    _fields_ = [("size", c_uint32), ("file", c_char_p), ("manifest", c_char_p), ("pulses", c_char_p), ("image", c_void_p), ("array", c_void_p), ("focus_m", POINTER(c_double)), ("record", c_uint32), ("cancel", POINTER(c_int32))]


class Field(Structure):
    _fields_ = [("size", c_uint32), ("quantity", c_char_p), ("array", c_void_p), ("drives", POINTER(c_double)), ("sets", c_size_t), ("elements", c_size_t), ("weights", POINTER(c_double)), ("points_m", POINTER(c_double)), ("points", c_size_t), ("x_m", POINTER(c_double)), ("y_m", POINTER(c_double)), ("z_m", POINTER(c_double)), ("x_count", c_size_t), ("y_count", c_size_t), ("z_count", c_size_t), ("region", c_char_p), ("region_name", c_char_p), ("extent_m", c_double), ("step_m", c_double), ("interpolation_error", c_double), ("pattern_error", c_double), ("threads", c_uint32), ("cancel", POINTER(c_int32))]


class Foci(Structure):
    _fields_ = [("size", c_uint32), ("array", c_void_p), ("foci", POINTER(Focus)), ("count", c_size_t), ("method", c_char_p), ("level", c_char_p), ("vary_amplitudes", c_int32), ("rounds", c_int32), ("drives", POINTER(c_double)), ("elements", c_size_t)]


class Port(Structure):
    _fields_ = [("size", c_uint32), ("port", c_char_p), ("baud", c_uint32), ("patience_ms", c_uint32), ("rig", c_char_p)]


class Identity(Structure):
    _fields_ = [("size", c_uint32), ("version_major", c_uint32), ("version_minor", c_uint32), ("channels", c_uint32), ("records", c_uint32), ("sequence_depth", c_uint32), ("clock_hz", c_uint32), ("foci", c_uint32), ("modulation_samples", c_uint32)]


class Status(Structure):
    _fields_ = [("size", c_uint32), ("connected", c_int32), ("enabled", c_int32), ("stopped", c_int32), ("busy", c_int32), ("present_index", c_uint32), ("underruns", c_uint32), ("refused_records", c_uint32), ("watchdog_trips", c_uint32), ("guard_trips", c_uint32), ("frames_damaged", c_uint32), ("foci_sent", c_uint64), ("lead_s", c_double), ("patterns_late", c_uint64), ("patterns_lost", c_uint64)]


class Playing(Structure):
    _fields_ = [("size", c_uint32), ("loops", c_int32), ("watchdog_ms", c_uint32), ("seconds", c_double), ("am", c_char_p), ("step_s", c_double), ("stale_ms", c_int32)]


class Trigger(Structure):
    _fields_ = [("size", c_uint32), ("event", c_uint32), ("every_periods", c_uint32), ("pulse_s", c_double), ("active_low", c_int32), ("gates", c_int32), ("settle_s", c_double)]


class TriggerTimes(Structure):
    _fields_ = [("size", c_uint32), ("out_count", c_uint32), ("in_count", c_uint32), ("now_clock", c_uint64), ("out_clock", c_uint64), ("in_clock", c_uint64)]


class LinkState(Structure):
    _fields_ = [("size", c_uint32), ("found_baud", c_uint32), ("retransmissions", c_uint64)]


# What each returns, and what it is given.
FUNCTIONS: dict[str, tuple[Any, list[Any]]] = {
    "haptogram_abi": (c_int32, []),
    "haptogram_version": (c_char_p, []),
    "haptogram_error": (c_char_p, []),
    "haptogram_error_place": (c_char_p, []),
    "haptogram_remedies": (c_char_p, []),
    "haptogram_compile": (c_int, [POINTER(Project), POINTER(c_void_p)]),
    "haptogram_compile_rig": (c_int, [POINTER(Project), c_char_p, c_char_p]),
    "haptogram_compile_path": (c_int, [POINTER(Path), POINTER(c_void_p)]),
    "haptogram_read_image": (c_int, [c_char_p, POINTER(c_void_p)]),
    "haptogram_save_image": (c_int, [c_void_p, c_char_p]),
    "haptogram_image_hex": (c_size_t, [c_void_p, c_void_p, c_size_t]),
    "haptogram_image_manifest": (c_size_t, [c_void_p, c_void_p, c_size_t]),
    "haptogram_image_warnings": (c_size_t, [c_void_p, c_void_p, c_size_t]),
    "haptogram_image_level": (c_size_t, [c_void_p, c_void_p, c_size_t]),
    "haptogram_free_image": (None, [c_void_p]),
    "haptogram_pressure": (c_int, [c_void_p, c_uint32, POINTER(c_double), c_size_t, POINTER(c_double)]),
    "haptogram_solve": (c_int, [c_char_p, POINTER(Focus), c_size_t, c_char_p, POINTER(c_double), POINTER(c_size_t)]),
    "haptogram_result_json": (c_size_t, [c_void_p, c_void_p, c_size_t]),
    "haptogram_result_numbers": (c_void_p, [c_void_p]),
    "haptogram_free_result": (None, [c_void_p]),
    "haptogram_array_names": (c_size_t, [c_void_p, c_size_t]),
    "haptogram_make_array": (c_int, [POINTER(ArraySource), POINTER(c_void_p)]),
    "haptogram_join": (c_int, [POINTER(PosedArray), c_size_t, c_char_p, POINTER(c_void_p)]),
    "haptogram_array_json": (c_size_t, [c_void_p, c_void_p, c_size_t]),
    "haptogram_array_elements": (c_void_p, [c_void_p]),
    "haptogram_unreachable": (c_size_t, [c_void_p, POINTER(c_double), c_void_p, c_size_t]),
    "haptogram_free_array": (None, [c_void_p]),
    "haptogram_image_foci": (c_size_t, [c_void_p, POINTER(c_double), c_size_t]),
    "haptogram_drives": (c_int, [POINTER(Source), POINTER(c_void_p), POINTER(c_void_p)]),
    "haptogram_analyze": (c_int, [POINTER(Source), c_double, POINTER(c_void_p)]),
    "haptogram_analyze_focus": (c_int, [c_void_p, POINTER(c_double), c_size_t, POINTER(c_double), c_char_p, POINTER(c_void_p)]),
    "haptogram_compute_field": (c_int, [POINTER(Field), POINTER(c_void_p)]),
    "haptogram_field_file": (c_int, [c_void_p, c_char_p, POINTER(c_void_p)]),
    "haptogram_solve_foci": (c_int, [POINTER(Foci), POINTER(c_void_p)]),
    "haptogram_quality": (c_int, [POINTER(Foci), POINTER(c_void_p)]),
    "haptogram_open": (c_int, [POINTER(Port), POINTER(c_void_p)]),
    "haptogram_close": (None, [c_void_p]),
    "haptogram_identify": (c_int, [c_void_p, POINTER(Identity)]),
    "haptogram_get_status": (c_int, [c_void_p, POINTER(Status)]),
    "haptogram_upload": (c_int, [c_void_p, c_void_p]),
    "haptogram_play": (c_int, [c_void_p, POINTER(Playing)]),
    "haptogram_play_live": (c_int, [c_void_p, POINTER(Playing)]),
    "haptogram_set_focus": (c_int, [c_void_p, c_double, c_double, c_double, c_double]),
    "haptogram_play_patterns": (c_int, [c_void_p, POINTER(Playing)]),
    "haptogram_put_patterns": (c_int, [c_void_p, POINTER(c_uint16), c_size_t, POINTER(c_size_t)]),
    "haptogram_set_pattern": (c_int, [c_void_p, POINTER(c_uint16)]),
    "haptogram_wait": (c_int, [c_void_p, c_uint32, POINTER(c_int32)]),
    "haptogram_stop": (c_int, [c_void_p]),
    "haptogram_shut_off": (c_int, [c_void_p]),
    "haptogram_set_intensity": (c_int, [c_void_p, c_double]),
    "haptogram_set_trigger": (c_int, [c_void_p, POINTER(Trigger)]),
    "haptogram_get_trigger_times": (c_int, [c_void_p, POINTER(TriggerTimes)]),
    "haptogram_open_link": (c_int, [POINTER(Port), POINTER(c_void_p)]),
    "haptogram_close_link": (None, [c_void_p]),
    "haptogram_link_identify": (c_int, [c_void_p]),
    "haptogram_link_ask": (c_int, [c_void_p, c_void_p, c_size_t, c_uint64]),
    "haptogram_link_shut_off": (c_int, [c_void_p]),
    "haptogram_link_wait": (c_int, [c_void_p, c_uint32, POINTER(c_int32)]),
    "haptogram_link_interrupt": (c_int, [c_void_p]),
    "haptogram_link_replies": (c_size_t, [c_void_p, c_void_p, c_size_t]),
    "haptogram_link_stream": (c_int, [c_void_p, c_uint64, POINTER(c_uint16), c_size_t]),
    "haptogram_link_keep_alive": (c_int, [c_void_p, c_uint32]),
    "haptogram_get_link_state": (c_int, [c_void_p, POINTER(LinkState)]),
    "haptogram_ports": (c_size_t, [c_void_p, c_size_t]),
}
