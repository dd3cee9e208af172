# SPDX-License-Identifier: Apache-2.0
"""Outputs that cannot be written, and outputs that are: whole, or not at all."""
import json
import os
import resource
import shutil
import signal
import stat
import subprocess
import time

import pytest
from patience import until
from support import BAD_INPUT, OK, PROGRAM, RUN_FAILED, assert_one_message, read_json, refuse, run, snapshot, succeed, text

CIRCLE = ["compile", "--shape", "circle"]

UNWRITABLE = {
    "a folder that is missing": "missing/image.hex",
    "a file for a folder": "file/image.hex",
    "a folder for a file": "folder",
    "a folder that takes no files": "/proc/image.hex",
    "a name too long": "x" * 300 + ".hex",
}


@pytest.fixture
def places(tmp_path):
    (tmp_path / "file").write_bytes(b"a file")
    (tmp_path / "folder").mkdir()
    return tmp_path


@pytest.mark.parametrize("place", UNWRITABLE)
def test_an_image_that_cannot_be_written(place, places):
    refuse(places, [*CIRCLE, "-o", UNWRITABLE[place], "--manifest", "image.json"], BAD_INPUT)


@pytest.mark.parametrize("place", UNWRITABLE)
def test_a_manifest_that_cannot_be_written(place, places):
    refuse(places, [*CIRCLE, "-o", "image.hex", "--manifest", UNWRITABLE[place]], BAD_INPUT)


def test_memory_words_that_cannot_be_written(places):
    refuse(places, [*CIRCLE, "-o", "image.hex", "--readmemh", "missing/words"], BAD_INPUT)
    (places / "words.sequence.mem").mkdir()
    refuse(places, [*CIRCLE, "-o", "image.hex", "--readmemh", "words"], BAD_INPUT)


@pytest.mark.parametrize("option", ["--pulses", "--report", "--trace"])
def test_what_simulate_cannot_write(option, small):
    others = [part for other in ("--pulses", "--report") if other != option for part in (other, f"new{other[1:]}")]
    refuse(small.folder, ["simulate", "image.hex", "--load", "direct", option, "missing/out", *others], BAD_INPUT, outputs=())
    refuse(small.folder, ["simulate", "image.hex", "--load", "direct", option, "image.hex/out", *others], BAD_INPUT, outputs=())


def test_what_field_cannot_write(small):
    succeed(["simulate", "image.hex", "--load", "direct", "--pulses", "pulses.csv"], cwd=small.folder)
    refuse(small.folder, ["field", "--pulses", "pulses.csv", "--manifest", "image.json", "--step", "40", "-o", "missing/f.csv"], BAD_INPUT, outputs=())


def test_a_full_device(tmp_path, full_device, small):
    refuse(tmp_path, [*CIRCLE, "-o", full_device, "--manifest", "image.json"], BAD_INPUT)
    refuse(tmp_path, [*CIRCLE, "-o", "image.hex", "--manifest", full_device], BAD_INPUT)
    assert stat.S_ISCHR(full_device.stat().st_mode)


def test_a_full_device_for_pulses_and_reports(small, full_device):
    for option, other in (("--pulses", "--report"), ("--report", "--pulses")):
        refuse(small.folder, ["simulate", "image.hex", "--load", "direct", option, full_device, other, "other"], BAD_INPUT,
               outputs=("other",))


def test_a_trace_on_a_full_device_neither_passes_nor_replaces_it(small, full_device):
    # By way of a link: a program that unlinks its trace before it writes would, as root, unlink the device.
    (small.folder / "trace.fst").symlink_to(full_device)
    refuse(small.folder, ["simulate", "image.hex", "--load", "direct", "--trace", "trace.fst"], BAD_INPUT, outputs=())
    assert stat.S_ISCHR(full_device.stat().st_mode)


@pytest.fixture
def tiny_disk(tmp_path):
    """A disk of 64 KiB, mounted for the test."""
    folder = tmp_path / "disk"
    folder.mkdir()
    if os.geteuid() != 0 or subprocess.run(["mount", "-t", "tmpfs", "-o", "size=64k", "none", folder], capture_output=True, check=False).returncode:
        pytest.skip("a small disk can only be mounted by root, where mounting is allowed")
    yield folder
    subprocess.run(["umount", folder], check=True)


def test_a_disk_that_fills_up(tiny_disk):
    refuse(tiny_disk, [*CIRCLE, "--points", "200", "-o", "image.hex"], BAD_INPUT)


def test_a_disk_that_fills_up_with_the_last_file(tiny_disk):
    (tiny_disk / "ballast").write_bytes(b"x" * (64 << 10))
    for name in ("image.hex", "image.json"):
        (tiny_disk / name).write_bytes(b"")
    os.truncate(tiny_disk / "ballast", 16 << 10)  # 48 KiB left: the image of 8 points fits, and not all the words with it
    refuse(tiny_disk, [*CIRCLE, "--points", "60", "-o", "image.hex", "--readmemh", "words"], BAD_INPUT,
           outputs=("image.hex", "image.json", "words.primary.mem"))


@pytest.mark.parametrize("name, command", [("a.png", ("feel", "image.hex")), ("a.svg", ("board", "pinout", "ulx3s-85f"))])
def test_a_disk_that_has_no_room_for_a_picture(name, command, tiny_disk, small):
    (tiny_disk / "ballast").write_bytes(b"x" * (60 << 10))
    result = run([*command, "-o", str(tiny_disk / name)], cwd=small.folder)
    assert_one_message(result, BAD_INPUT)
    assert b"Traceback" not in result.stderr and [file.name for file in tiny_disk.iterdir()] == ["ballast"]


def test_a_python_without_matplotlib(tmp_path, small):
    python = tmp_path / "python"
    python.write_text("#!/bin/sh\nexec python3 -S -I \"$@\"\n")
    python.chmod(0o755)
    result = run(["feel", "image.hex", "-o", str(tmp_path / "picture.png")], cwd=small.folder, env={**os.environ, "HAPTOGRAM_PYTHON": str(python)})
    assert_one_message(result, BAD_INPUT)


@pytest.mark.parametrize("limit", [0, 100, 1000, 5000])
def test_a_limit_on_the_size_of_files(limit, tmp_path):
    refuse(tmp_path, [*CIRCLE, "--points", "8", "-o", "image.hex"], BAD_INPUT,
           preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit)))


# Below some 20 kB the FST writer of Verilator, which maps what it writes, is stopped by a bus error before it can say so.
def test_a_limit_on_the_size_of_the_trace(small):
    result = run(["simulate", "image.hex", "--load", "direct", "--trace", "trace.fst"], cwd=small.folder,
                 preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (30000, 30000)))
    assert_one_message(result, BAD_INPUT)
    assert not (small.folder / "trace.fst").exists()


def test_an_image_that_no_model_plays_leaves_the_old_trace(tmp_path):
    (tmp_path / "array.toml").write_text("[array]\nrows = 2\ncolumns = 2\npitch_mm = 10\n[board]\nchannels = 7\n")
    succeed([*CIRCLE, "--points", 4, "--center", "0,0,80", "--array", "array.toml", "-o", "image.hex"], cwd=tmp_path)
    refuse(tmp_path, ["simulate", "image.hex", "--trace", "trace.fst", "--pulses", "pulses.csv"], BAD_INPUT,
           outputs=("trace.fst", "pulses.csv"))
    (tmp_path / "trace.fst").unlink()
    refuse(tmp_path, ["simulate", "image.hex", "--trace", "trace.fst"], BAD_INPUT, outputs=())


def test_outputs_replace_old_ones_and_keep_their_mode_and_links(tmp_path):
    (tmp_path / "real.hex").write_bytes(b"old")
    (tmp_path / "real.hex").chmod(0o640)
    (tmp_path / "image.hex").symlink_to("real.hex")
    succeed([*CIRCLE, "--points", 3, "-o", "image.hex"], cwd=tmp_path, preexec_fn=lambda: os.umask(0o027))
    assert (tmp_path / "image.hex").is_symlink() and (tmp_path / "real.hex").read_bytes().endswith(b":00000001FF\n")
    assert stat.S_IMODE((tmp_path / "real.hex").stat().st_mode) == 0o640
    assert stat.S_IMODE((tmp_path / "image.json").stat().st_mode) == 0o640  # by the umask
    assert sorted(p.name for p in tmp_path.iterdir()) == ["image.hex", "image.json", "real.hex"]


def test_kill_in_the_middle_leaves_the_old_file_or_the_new(tmp_path):
    arguments = [str(PROGRAM), *CIRCLE, "--points", "400", "-o", "image.hex"]
    begun = time.monotonic()
    succeed(arguments[1:], cwd=tmp_path)
    whole = time.monotonic() - begun  # on a busy machine, too: some kills come before its end
    new = {name: (tmp_path / name).read_bytes() for name in ("image.hex", "image.json")}
    old = {name: b"old " * 30000 for name in new}
    killed = 0
    for step in range(0, 24, 2):
        for name, content in old.items():
            (tmp_path / name).write_bytes(content)
        process = subprocess.Popen(arguments, cwd=tmp_path, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        time.sleep(whole * step / 20)
        process.kill()
        killed += process.wait(300) == -signal.SIGKILL
        for name in new:
            assert (tmp_path / name).read_bytes() in (old[name], new[name]), f"{name} is half-written after {whole * step / 20:.3f} s"
    assert killed > 0, "never killed in time; this tested nothing"


def test_kill_during_a_simulation_leaves_no_half_trace(small):
    (small.folder / "trace.fst").write_bytes(b"old")
    process = subprocess.Popen([str(PROGRAM), "simulate", "image.hex", "--trace", "trace.fst", "--passes", "65535"], cwd=small.folder,
                               stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    until(lambda: any(path.stat().st_size > 0 for path in small.folder.iterdir() if "trace.fst" in path.name and path.name != "trace.fst"), "a trace that is being written")
    process.kill()
    assert process.wait(300) == -signal.SIGKILL, "it ended before; this tested nothing"
    assert (small.folder / "trace.fst").read_bytes() == b"old"


@pytest.mark.parametrize("command", [["inspect", "image.hex"], ["inspect", "image.hex", "--json"], [*CIRCLE, "-o", "new.hex", "--json"], [*CIRCLE, "-o", "new.hex"],
                                     [*CIRCLE, "-o", "-", "--manifest", "new.json"], ["simulate", "image.hex", "--load", "direct"],
                                     ["simulate", "image.hex", "--load", "direct", "--json"], ["simulate", "image.hex", "--load", "direct", "--pulses", "-"],
                                     ["compile", "--help"], ["--version"]], ids=" ".join)
def test_standard_output_on_a_full_disk(command, small, full_device):
    with open(full_device, "wb") as full:
        result = run(command, cwd=small.folder, stdout=full)
    assert_one_message(result, BAD_INPUT)


@pytest.mark.parametrize("command", [["inspect", "image.hex", "--json"], [*CIRCLE, "-o", "-", "--manifest", "new.json"]], ids=" ".join)
def test_standard_output_that_is_closed(command, small):
    result = run(command, cwd=small.folder, stdout=None, preexec_fn=lambda: os.close(1))
    assert result.returncode in (BAD_INPUT, RUN_FAILED), "data were lost without a word"
    assert text(result.stderr).startswith("haptogram: ") and text(result.stderr).count("\n") == 1


@pytest.mark.parametrize("command", [["inspect", "big.hex", "--json"], ["inspect", "big.hex"], [*CIRCLE, "-o", "-", "--manifest", "new.json"]], ids=" ".join)
def test_a_reader_that_goes_away(command, tmp_path):
    succeed([*CIRCLE, "--points", 400, "-o", "big.hex"], cwd=tmp_path)
    process = subprocess.Popen([str(PROGRAM), *command], cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    assert process.stdout.readline()
    process.stdout.close()
    message = text(process.stderr.read())
    code = process.wait(300)
    assert code == -signal.SIGPIPE or code == OK or (code == BAD_INPUT and "Broken pipe" in message and message.count("\n") == 1), (code, message)
    process.stderr.close()


def test_a_closed_pipe_does_not_spoil_the_manifest(tmp_path):
    # When the image never arrives, a manifest that speaks of it is a half-written output.
    reading, writing = os.pipe()
    os.close(reading)
    result = run([*CIRCLE, "-o", "-", "--manifest", "new.json"], cwd=tmp_path, stdout=writing)
    os.close(writing)
    assert_one_message(result, BAD_INPUT)
    assert snapshot(tmp_path) == {}


@pytest.mark.parametrize("how", ["closed", "full"])
def test_messages_that_nobody_can_read_change_no_exit_code(how, tmp_path, full_device):
    for arguments, code in (([*CIRCLE, "--points", "400", "--rate", "50"], OK), (["compile", "missing.ply"], BAD_INPUT), (["inspect", "missing.hex"], BAD_INPUT)):
        if how == "closed":
            result = run(arguments, cwd=tmp_path, stderr=None, preexec_fn=lambda: os.close(2))
        else:
            with open(full_device, "wb") as full:
                result = run(arguments, cwd=tmp_path, stderr=full)
        assert result.returncode == code, f"{arguments}: {result.returncode}"


def test_a_closed_stderr_never_lets_messages_into_a_file(tmp_path):
    # Descriptor 2 is then the next that open() returns.
    run([*CIRCLE, "--points", "400", "--rate", "50", "-o", "image.hex"], cwd=tmp_path, stderr=None, preexec_fn=lambda: os.close(2))
    for name in ("image.hex", "image.json"):
        assert b"warning" not in (tmp_path / name).read_bytes()


def test_no_terminal_no_progress(small):
    result = succeed(["simulate", "image.hex", "--passes", 3], cwd=small.folder)
    assert result.stderr == b"" and b"\r" not in result.stdout and b"\x1b" not in result.stdout


def test_progress_on_a_terminal_goes_to_stderr_only(small):
    try:
        master, slave = os.openpty()
    except OSError as error:
        pytest.skip(f"no pseudo-terminals here: {error}")
    process = subprocess.Popen([str(PROGRAM), "simulate", "image.hex", "--json"], cwd=small.folder, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=slave)
    os.close(slave)
    output = process.stdout.read()
    shown = b""
    try:
        while part := os.read(master, 65536):
            shown += part
    except OSError:  # the terminal has gone with its last user
        pass
    os.close(master)
    process.stdout.close()
    assert process.wait(300) == OK
    assert json.loads(output)["points"] == 8
    assert b"%" in shown and shown.endswith(b"\x1b[K"), "no progress, or it is left standing"


LOCALES = ["C", "C.UTF-8", "de_DE.UTF-8", "no_SUCH.locale"]


@pytest.mark.parametrize("locale", LOCALES)
@pytest.mark.parametrize("variable", ["LC_ALL", "LC_NUMERIC", "LANG"])
def test_other_locales_change_nothing(locale, variable, tmp_path):
    arguments = [*CIRCLE, "--points", "5", "--rate", "7.5", "--scale", "1.5", "-o", "image.hex", "--readmemh", "words"]
    (tmp_path / "a").mkdir()
    (tmp_path / "b").mkdir()
    plain = succeed(arguments, cwd=tmp_path / "a", env={"LC_ALL": "C"})
    clean = {key: value for key, value in os.environ.items() if not key.startswith("LC_") and key != "LANG"}
    other = subprocess.run([str(PROGRAM), *arguments], cwd=tmp_path / "b", env={**clean, variable: locale}, capture_output=True, check=False, timeout=300)
    assert other.returncode == OK and other.stdout == plain.stdout and other.stderr == plain.stderr
    assert snapshot(tmp_path / "a") == snapshot(tmp_path / "b")


def test_a_locale_with_a_decimal_comma(tmp_path):
    """Debian ships no such locale compiled, but the means to compile one."""
    folder = tmp_path / "locales"
    folder.mkdir()
    made = shutil.which("localedef") and subprocess.run(["localedef", "-i", "de_DE", "-f", "UTF-8", folder / "de_DE.UTF-8"], capture_output=True, check=False)
    if not made or made.returncode > 1 or not (folder / "de_DE.UTF-8").exists():
        pytest.skip("no localedef, or no locale sources (package locales)")
    environment = {"LC_ALL": "de_DE.UTF-8", "LOCPATH": str(folder)}
    comma = subprocess.run(["locale", "decimal_point"], env={**os.environ, **environment}, capture_output=True, check=False)
    assert comma.stdout == b",\n", "the locale is not in force; this would test nothing"
    arguments = ["compile", "cloud.xyz", "--rate", "7.5", "-o", "image.hex"]
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "cloud.xyz").write_bytes(b"0.5 0.25 100.5\n9.5 0 100\n0 9.75 100\n")
    succeed(arguments, cwd=tmp_path / "a")
    succeed(arguments, cwd=tmp_path / "b", env=environment)
    assert snapshot(tmp_path / "a") == snapshot(tmp_path / "b")
    assert [0.5, 0.25, 100.5] in [r["focus_mm"] for r in read_json(tmp_path / "a" / "image.json")["records"]]


@pytest.mark.parametrize("command", [["field", "--focus", "0,0,150"], ["analyze", "--focus", "0,0,150", "--json"]], ids=" ".join)
def test_a_reader_that_has_seen_enough(command, tmp_path):
    reading, writing = os.pipe()
    os.close(reading)
    result = run(command, cwd=tmp_path, stdout=writing)
    os.close(writing)
    assert (result.returncode, result.stderr) == (-signal.SIGPIPE, b"")
