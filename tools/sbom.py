# SPDX-License-Identifier: Apache-2.0
"""What a release contains beside our own sources: the packages of the studio's page, the Debian packages whose headers or libraries are
compiled in, and those whose libraries a wheel has beside them.

    sbom.py bill VERSION OUTPUT   writes that as CycloneDX; OUTPUT's folder may hold a wheel
    sbom.py notices WHEEL         puts the licences of these Debian packages into the wheel; those of the page lie beside the page
"""
import base64
import hashlib
import json
import re
import subprocess
import sys
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
COMPILED_IN = ("libboost-dev", "libbullet-dev", "libcli11-dev", "libeigen3-dev", "libfmt-dev", "libftdi1-dev", "libhwy-dev", "libminizip-dev", "libnanoflann-dev",
               "libpng-dev", "libpugixml-dev", "libtbb-dev", "libtomlplusplus-dev", "nlohmann-json3-dev", "verilator", "zlib1g-dev")


def of_the_page():
    locked = json.loads((ROOT / "extras/studio/web/package-lock.json").read_text(encoding="utf-8"))["packages"]
    for path, package in sorted(locked.items()):
        if path and not package.get("dev") and not package.get("optional"):
            name = path.removeprefix("node_modules/")
            yield {"type": "library", "name": name, "version": package["version"], "purl": f"pkg:npm/{name.replace('@', '%40')}@{package['version']}",
                   "licenses": [{"license": {"id": package["license"]}}]}


def bundled_in(wheel):
    """The Debian packages of the libraries that auditwheel took along, under names with a hash."""
    names = {Path(name).name for name in zipfile.ZipFile(wheel).namelist() if name.partition("/")[0].endswith(".libs") and not name.endswith("/")}
    for name in sorted(re.sub(r"-[0-9a-f]{8}(?=\.)", "", name, count=1) for name in names):
        owners = subprocess.run(["dpkg-query", "-S", f"*/{name}"], capture_output=True, text=True).stdout
        if not owners:
            sys.exit(f"sbom: {wheel} has {name}, which no Debian package on this machine owns")
        yield owners.partition(":")[0]


def debian_packages(wheels):
    for name in sorted({*COMPILED_IN, *(name for wheel in wheels for name in bundled_in(wheel))}):
        found = subprocess.run(["dpkg-query", "-W", "-f=${Version}", name], capture_output=True, text=True)
        if found.returncode == 0:  # an option may be left out
            yield name, found.stdout


def bill(version, output):
    debian = [{"type": "library", "name": name, "version": found, "purl": f"pkg:deb/debian/{name}@{found}"}
              for name, found in debian_packages(Path(output).parent.glob("*.whl"))]
    document = {"bomFormat": "CycloneDX", "specVersion": "1.5", "version": 1,
                "metadata": {"component": {"type": "application", "name": "haptogram", "version": version, "licenses": [{"license": {"id": "Apache-2.0"}}]}},
                "components": [*of_the_page(), *debian]}
    Path(output).write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")


def notices(wheel):
    parts = [f"{'=' * 79}\n{name} {version}\n{'=' * 79}\n\n{Path('/usr/share/doc', name, 'copyright').read_text(encoding='utf-8')}"
             for name, version in debian_packages([wheel])]
    with zipfile.ZipFile(wheel) as packed:
        files = {entry: packed.read(entry) for entry in packed.infolist()}
    (record,) = (entry for entry in files if entry.filename.endswith(".dist-info/RECORD"))
    name, text = record.filename.replace("RECORD", "licenses/NOTICES.txt"), "\n".join(parts).encode()
    digest = base64.urlsafe_b64encode(hashlib.sha256(text).digest()).rstrip(b"=").decode()
    files[record] += f"{name},sha256={digest},{len(text)}\n".encode()
    beside = Path(f"{wheel}.new")
    with zipfile.ZipFile(beside, "w", zipfile.ZIP_DEFLATED) as packed:
        for entry, content in files.items():
            if entry is record:
                packed.writestr(zipfile.ZipInfo(name, record.date_time), text, zipfile.ZIP_DEFLATED)
            packed.writestr(entry, content, zipfile.ZIP_DEFLATED)
    beside.replace(wheel)


if __name__ == "__main__":
    {"bill": bill, "notices": notices}[sys.argv[1]](*sys.argv[2:])
