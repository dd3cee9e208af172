# SPDX-License-Identifier: Apache-2.0
"""What all suites share, so that one pytest may run several of them: a place for remembered rates, what was said, and a table of figures against the clock."""
import os
import shutil
import tempfile

import messages
import pytest

BEYOND = 3  # times the target: then a case fails

# For the rates that programs remember: each worker has its own, before any module copies the environment.
os.environ["XDG_STATE_HOME"] = tempfile.mkdtemp(prefix="haptogram-state-")


def pytest_unconfigure():
    shutil.rmtree(os.environ["XDG_STATE_HOME"], ignore_errors=True)


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items):
    """Cases with a fixture that their module calls MADE_ONCE are one worker's, when there are several workers, and groups begin first."""
    for item in items:
        if set(item.fixturenames) & set(getattr(item.module, "MADE_ONCE", ())):
            item.add_marker(pytest.mark.xdist_group(item.module.__name__))
    items.sort(key=lambda item: not any(item.iter_markers("xdist_group")))


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item):
    """Before its fixtures: those of one case may hear messages, too."""
    messages.begin(name_of(item), item.config._tmp_path_factory.getbasetemp())


def name_of(item):
    return f"{item.path.name}: {item.name}"


def pytest_deselected(items):
    if os.environ.get("PYTEST_XDIST_WORKER", "gw0") == "gw0":
        messages.left_out(map(name_of, items))


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_makereport(item, call):
    report = (yield).get_result()
    if report.when == "call" and report.passed:
        messages.end()


@pytest.fixture
def figure(record_property):
    """figure(what, found, target, unit): a line of the table at the end; only beyond three times the target it fails."""

    def tell(what, found, target, unit="s"):
        record_property("figure", (what, float(found), target, unit))
        assert found <= BEYOND * target, f"{what}: {found:.3g} {unit}, the target is {target:g} {unit}"

    return tell


def pytest_report_header():
    return f"program: {os.environ.get('HAPTOGRAM_PROGRAM', 'build/release/host/cli/haptogram')}"


def pytest_terminal_summary(terminalreporter):
    reports = [report for kind in ("passed", "failed") for report in terminalreporter.stats.get(kind, []) if getattr(report, "when", "") == "call"]
    figures = [value for report in reports for name, value in report.user_properties if name == "figure"]
    if figures:
        terminalreporter.section("figures beside targets")
        for what, found, target, unit in figures:
            mark = "" if found <= target else "  beyond the target" if found <= BEYOND * target else "  FAILED"
            terminalreporter.write_line(f"{what:72} {found:9.3g}  target {target:g} {unit}{mark}")
