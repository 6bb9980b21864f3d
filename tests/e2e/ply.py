# Reads the binary PLY files of kintsugi-map, independently of Kintsugi's own reader.
# SPDX-License-Identifier: BSD-3-Clause
import struct

TYPES = {"float": "f", "uchar": "B", "int": "i", "uint": "I"}


def read_ply(path):
    """(vertices, triangles): vertices as tuples x, y, z, nx, ny, nz, ..., triangles as tuples of indices."""
    content = path.read_bytes()
    end = content.index(b"end_header\n") + len(b"end_header\n")
    counts, formats = {}, {}
    for line in content[:end].decode("ascii").splitlines():
        words = line.split()
        if words[0] == "element":
            element = words[1]
            counts[element], formats[element] = int(words[2]), "<"
        elif words[0] == "property" and words[1] == "list":
            formats[element] += TYPES[words[2]] + "3" + TYPES[words[3]]
        elif words[0] == "property":
            formats[element] += TYPES[words[1]]
    vertex, face = struct.Struct(formats["vertex"]), struct.Struct(formats["face"])
    middle = end + counts["vertex"] * vertex.size
    vertices = list(vertex.iter_unpack(content[end:middle]))
    triangles = [row[1:] for row in face.iter_unpack(content[middle : middle + counts["face"] * face.size])]
    return vertices, triangles


def winding_agreement(mesh):
    """Share of triangles that run counter-clockwise seen from the side to which their vertices' normals point."""
    vertices, triangles = mesh
    agreeing = 0
    for corners in triangles:
        a, b, c = (vertices[i] for i in corners)
        u, v = [b[k] - a[k] for k in range(3)], [c[k] - a[k] for k in range(3)]
        n = (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])
        agreeing += sum(n[k] * (a[3 + k] + b[3 + k] + c[3 + k]) for k in range(3)) > 0
    return agreeing / len(triangles)
