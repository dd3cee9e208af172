# SPDX-License-Identifier: Apache-2.0
"""Small PCD, 3MF, glTF and SVG files, as cameras, slicers, modellers and drawing programs write them."""
import base64
import io
import json
import struct
import zipfile


def lzf(data):
    """Packed as LibLZF packs: what repeats nine bytes or more of the last 8 KiB is a copy, all else stands as it is."""
    out, plain, at, known = bytearray(), bytearray(), 0, {}

    def flush():
        for begin in range(0, len(plain), 32):
            part = plain[begin : begin + 32]
            out.append(len(part) - 1)
            out.extend(part)
        plain.clear()

    while at < len(data):
        key, length = data[at : at + 9], 0
        found = known.get(key, -1) if len(key) == 9 else -1
        known[key] = at
        if found >= 0 and at - found <= 8192:
            while at + length < len(data) and length < 264 and data[found + length] == data[at + length]:
                length += 1
        if length < 9:
            plain.append(data[at])
            at += 1
            continue
        flush()
        back = at - found - 1
        out.extend((7 << 5 | back >> 8, length - 9, back & 255))
        at += length
    flush()
    return bytes(out)


def pcd(points, data="ascii", width=None, extra=True, kind="f"):
    """A cloud with a colour before z, so that the fields are no block."""
    width = width or len(points)
    size = struct.calcsize(kind)
    fields = "FIELDS x y rgb z\nSIZE {0} {0} 4 {0}\nTYPE F F U F\nCOUNT 1 1 1 1\n" if extra else "FIELDS x y z\nSIZE {0} {0} {0}\nTYPE F F F\nCOUNT 1 1 1\n"
    header = f"# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\n{fields.format(size)}WIDTH {width}\nHEIGHT {len(points) // width}\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {len(points)}\nDATA {data}\n"
    row = lambda p: (p[0], p[1], 4278190335, p[2]) if extra else p  # noqa: E731
    form = f"<2{kind}I{kind}" if extra else f"<3{kind}"
    if data == "ascii":
        return header.encode() + "".join(" ".join(f"{number:.9g}" for number in row(p)) + "\n" for p in points).encode()
    if data == "binary":
        return header.encode() + b"".join(struct.pack(form, *row(p)) for p in points)
    columns = b"".join(struct.pack(f"<{len(points)}{each}", *(row(p)[k] for p in points)) for k, each in enumerate(f"{kind}{kind}I{kind}" if extra else kind * 3))
    packed = lzf(columns)
    return header.encode() + struct.pack("<2I", len(packed), len(columns)) + packed


RELATIONS = '<?xml version="1.0"?><Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships"><Relationship Target="/3D/3dmodel.model" Id="rel0" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>'
CORE = 'xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02"'


def mesh_xml(points, faces):
    vertices = "".join(f'<vertex x="{x!r}" y="{y!r}" z="{z!r}"/>' for x, y, z in points)
    triangles = "".join(f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in faces)
    return f"<mesh><vertices>{vertices}</vertices><triangles>{triangles}</triangles></mesh>"


def model_xml(resources, build, unit="millimeter", more=""):
    return f'<?xml version="1.0" encoding="UTF-8"?>\n<model unit="{unit}" {CORE} {more}><metadata name="Title">ours</metadata><resources>{resources}</resources><build>{build}</build></model>'


def three_mf(model, others=(), relations=RELATIONS):
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in (("_rels/.rels", relations), ("3D/3dmodel.model", model), *others):
            if content is not None:
                archive.writestr(zipfile.ZipInfo(name), content, zipfile.ZIP_DEFLATED)
    return file.getvalue()


def gltf(points, corners=None, buffer="embedded", mode=4, nodes=None, kind="H"):
    """A mesh of one primitive; `buffer`: embedded, glb, or the name of a file beside it. @return the file, and that file"""
    data = b"".join(struct.pack("<3f", *p) for p in points)
    accessors = [{"bufferView": 0, "componentType": 5126, "count": len(points), "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 1]}]
    views = [{"buffer": 0, "byteLength": len(data)}]
    primitive = {"attributes": {"POSITION": 0}, "mode": mode}
    if corners:
        packed = struct.pack(f"<{len(corners)}{kind}", *corners)
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": len(packed)})
        accessors.append({"bufferView": 1, "componentType": {"B": 5121, "H": 5123, "I": 5125}[kind], "count": len(corners), "type": "SCALAR"})
        primitive["indices"] = 1
        data += packed
    document = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": nodes or [{"mesh": 0}], "meshes": [{"primitives": [primitive]}],
                "accessors": accessors, "bufferViews": views, "buffers": [{"byteLength": len(data)}]}  # fmt: skip
    if buffer == "glb":
        text = json.dumps(document).encode()
        text += b" " * (-len(text) % 4)
        data += b"\0" * (-len(data) % 4)
        return struct.pack("<4s2I", b"glTF", 2, 28 + len(text) + len(data)) + struct.pack("<2I", len(text), 0x4E4F534A) + text + struct.pack("<2I", len(data), 0x004E4942) + data, b""
    document["buffers"][0]["uri"] = "data:application/octet-stream;base64," + base64.b64encode(data).decode() if buffer == "embedded" else buffer
    return json.dumps(document).encode(), data


def svg(content, size='width="100mm" height="100mm" viewBox="0 0 100 100"'):
    return f'<?xml version="1.0"?>\n<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" {size}>{content}</svg>\n'.encode()
