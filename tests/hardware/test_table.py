# SPDX-License-Identifier: Apache-2.0
"""A row of `make hardware` holds only when the finding is within its bounds and the planted fault is not."""
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "extras/hardware"))
from table import Row, text  # noqa: E402


@pytest.mark.parametrize(
    "found, with_fault, verdict",
    [(1.0, 2.1, "ok"), (2.0, 0.9, "ok"), (2.1, 3.0, "MISSED"), (1.5, 1.5, "fault not noticed"), (float("nan"), 3.0, "MISSED")],
)
def test_the_verdict_of_a_row(found, with_fault, verdict):
    row = Row("a check", found, 1.0, 2.0, "a fault", with_fault)
    assert row.verdict == verdict
    assert text([row]).splitlines()[-1].endswith(f"| {verdict} |")
