# SPDX-License-Identifier: Apache-2.0
"""Writes what a release contains beside our own sources, as CycloneDX: the packages of the studio's page, and the Debian packages whose
headers or libraries are compiled in. Usage: sbom.py VERSION OUTPUT"""
import json
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
COMPILED_IN = ("libboost-dev", "libbullet-dev", "libcli11-dev", "libeigen3-dev", "libfmt-dev", "libftdi1-dev", "libhwy-dev", "libminizip-dev", "libnanoflann-dev",
               "libpng-dev", "libtbb-dev", "libtomlplusplus-dev", "nlohmann-json3-dev", "verilator", "zlib1g-dev")


def of_the_page():
    locked = json.loads((ROOT / "host/studio/web/package-lock.json").read_text(encoding="utf-8"))["packages"]
    for path, package in sorted(locked.items()):
        if path and not package.get("dev") and not package.get("optional"):
            name = path.removeprefix("node_modules/")
            yield {"type": "library", "name": name, "version": package["version"], "purl": f"pkg:npm/{name.replace('@', '%40')}@{package['version']}",
                   "licenses": [{"license": {"id": package["license"]}}]}


def of_debian():
    for name in COMPILED_IN:
        found = subprocess.run(["dpkg-query", "-W", "-f=${Version}", name], capture_output=True, text=True)
        if found.returncode == 0:  # an option may be left out
            yield {"type": "library", "name": name, "version": found.stdout, "purl": f"pkg:deb/debian/{name}@{found.stdout}"}


def main():
    version, output = sys.argv[1:]
    bill = {"bomFormat": "CycloneDX", "specVersion": "1.5", "version": 1,
            "metadata": {"component": {"type": "application", "name": "haptogram", "version": version, "licenses": [{"license": {"id": "Apache-2.0"}}]}},
            "components": [*of_the_page(), *of_debian()]}
    Path(output).write_text(json.dumps(bill, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
