# SPDX-License-Identifier: Apache-2.0
"""Rows of `make hardware`: what a check found, its bounds, and what it found with a fault planted, which must be outside them."""
import dataclasses


@dataclasses.dataclass
class Row:
    check: str
    found: float
    low: float
    high: float
    fault: str
    found_with_fault: float

    def holds(self, value):
        return self.low <= value <= self.high

    @property
    def verdict(self):
        if not self.holds(self.found):
            return "MISSED"
        return "fault not noticed" if self.holds(self.found_with_fault) else "ok"


def text(rows):
    lines = ["| check | found | bound | planted fault | found with it | |", "|---|---|---|---|---|---|"]
    for r in rows:
        bound = f"{r.low:g}" if r.low == r.high else f"{r.low:g} to {r.high:g}"
        lines.append(f"| {r.check} | {r.found:.4g} | {bound} | {r.fault} | {r.found_with_fault:.4g} | {r.verdict} |")
    return "\n".join(lines) + "\n"
