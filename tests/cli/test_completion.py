# SPDX-License-Identifier: Apache-2.0
"""Completion scripts and the manual page, which the program makes from its own options."""

import shutil
import subprocess

import pytest

from support import USAGE, refuse, succeed, text

COMMANDS = ["compile", "inspect", "simulate", "solve", "render", "field", "scatter", "analyze", "calibrate", "magnitude", "robot", "movement", "interact",
            "board", "bitstream", "device", "upload", "download",
            "play", "stream", "studio", "completion"]  # fmt: skip


def printed(kind, folder):
    path = folder / f"haptogram.{kind}"
    path.write_bytes(succeed(["completion", kind], cwd=folder).stdout)
    return path


def completed_by_bash(folder, *words):
    """What bash offers for the last word."""
    script = printed("bash", folder)
    line = " ".join(f"'{word}'" for word in words)
    command = f'source {script}; COMP_WORDS=({line}); COMP_CWORD={len(words) - 1}; _haptogram; printf "%s\\n" "${{COMPREPLY[@]}}"'
    return subprocess.run(["bash", "-c", command], cwd=folder, capture_output=True, text=True, check=True).stdout.split()


def test_bash_offers_commands_options_values_and_files(tmp_path):
    (tmp_path / "ring.hex").write_text("")
    offered = completed_by_bash(tmp_path, "haptogram", "")
    assert set(COMMANDS) <= set(offered)
    assert completed_by_bash(tmp_path, "haptogram", "comp") == ["compile", "completion"]
    assert "--diameter" in completed_by_bash(tmp_path, "haptogram", "compile", "--d")
    assert completed_by_bash(tmp_path, "haptogram", "field", "--quantity", "r") == ["radiation", "rms"]
    assert completed_by_bash(tmp_path, "haptogram", "inspect", "ri") == ["ring.hex"]
    assert completed_by_bash(tmp_path, "haptogram", "board", "pin") == ["pinout"]
    assert "--pty" in completed_by_bash(tmp_path, "haptogram", "board", "run", "--")


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_the_shell_can_read_it(shell, tmp_path):
    if shutil.which(shell) is None:
        pytest.skip(f"{shell} is not installed")
    subprocess.run([shell, "-n", printed(shell, tmp_path)], check=True)


@pytest.mark.parametrize("kind", ["zsh", "fish", "man"])
def test_every_command_is_in_it(kind, tmp_path):
    content = printed(kind, tmp_path).read_text()
    assert all(command in content for command in COMMANDS)


def test_the_manual_page(tmp_path):
    page = printed("man", tmp_path)
    content = page.read_text()
    assert content.startswith(".TH HAPTOGRAM 1") and ".SS haptogram board run" in content and r"\fB\-\-quantity\fR" in content
    if shutil.which("groff") is not None:
        result = subprocess.run(["groff", "-man", "-Tutf8", "-ww", page], capture_output=True, text=True, check=True)
        assert result.stderr == "" and "4 device or link" in result.stdout


def test_another_shell(tmp_path):
    result = refuse(tmp_path, ["completion", "tcsh"], USAGE)
    assert result is None or "tcsh" in text(result.stderr)
