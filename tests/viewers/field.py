"""Reads the files difusa writes, and PNG, with nothing but Python's standard library: what the viewers show is compared
with what is in the files, read without them."""
import array
import base64
import struct
import sys
import xml.etree.ElementTree
import zlib

VTP_TYPES = {"Float64": "d", "Float32": "f", "Int64": "q", "Int32": "i", "UInt8": "B", "Int8": "b", "UInt32": "I",
             "UInt64": "Q"}
PLY_TYPES = {"float": "f", "double": "d", "char": "b", "uchar": "B", "short": "h", "ushort": "H", "int": "i",
             "uint": "I"}


def decoded(text, kind, header):
    """The numbers of a DataArray in VTK's inline binary form: a header of sizes, then zlib blocks, both in base64."""
    text = "".join(text.split())
    size = struct.calcsize(header)
    first = 4 * ((size * 3 + 2) // 3)
    blocks = struct.unpack("<3" + header, base64.b64decode(text[:first])[:3 * size])[0]
    length = 4 * ((size * (3 + blocks) + 2) // 3)
    sizes = struct.unpack("<%d%s" % (3 + blocks, header), base64.b64decode(text[:length])[:size * (3 + blocks)])[3:]
    packed = base64.b64decode(text[length:])
    content, at = b"", 0
    for block in sizes:
        content += zlib.decompress(packed[at:at + block])
        at += block
    return array.array(kind, content)


def read_vtp(file):
    """Point arrays, {"points", coordinates} among them, and cell arrays with "connectivity": name -> flat numbers; and
    name -> number of components."""
    root = xml.etree.ElementTree.parse(file).getroot()
    header = {"UInt32": "I", "UInt64": "Q"}[root.get("header_type", "UInt32")]
    piece = root.find("PolyData/Piece")
    components, points, cells = {}, {}, {}
    for place, into in (("PointData", points), ("Points", points), ("CellData", cells), ("Polys", cells)):
        for data in piece.findall(place + "/DataArray"):
            name = "points" if place == "Points" else data.get("Name")
            components[name] = int(data.get("NumberOfComponents") or 1)
            if data.get("format") != "binary":
                sys.exit("%s: %s is not inline binary" % (file, name))
            into[name] = decoded(data.text or "", VTP_TYPES[data.get("type")], header)
    return components, points, cells


def read_ply_vertices(file):
    """Name -> numbers of the vertex properties of a binary PLY of this machine's byte order."""
    with open(file, "rb") as stream:
        content = stream.read()
    head, _, body = content.partition(b"end_header\n")
    lines = head.decode("ascii", "replace").splitlines()
    if "format binary_little_endian 1.0" not in lines:
        sys.exit("%s: is not binary PLY" % file)
    start = next(i for i, line in enumerate(lines) if line.startswith("element vertex "))
    count = int(lines[start].split()[2])
    names, form = [], "<"
    for line in lines[start + 1:]:
        words = line.split()
        if words[0] != "property":
            break
        names.append(words[2])
        form += PLY_TYPES[words[1]]
    rows = struct.iter_unpack(form, body[:count * struct.calcsize(form)])
    return dict(zip(names, zip(*rows)))


class Picture:
    """An 8-bit RGB or RGBA PNG."""

    def __init__(self, file):
        with open(file, "rb") as stream:
            content = stream.read()
        if content[:8] != b"\x89PNG\r\n\x1a\n":
            sys.exit("%s: is not a PNG" % file)
        at, packed = 8, b""
        while at < len(content):
            length, kind = struct.unpack(">I4s", content[at:at + 8])
            chunk = content[at + 8:at + 8 + length]
            if kind == b"IHDR":
                self.width, self.height, depth, colours, _, _, interlaced = struct.unpack(">IIBBBBB", chunk)
                if depth != 8 or colours not in (2, 6) or interlaced:
                    sys.exit("%s: is not a plain RGB picture" % file)
            elif kind == b"IDAT":
                packed += chunk
            at += length + 12
        self.channels = 3 if colours == 2 else 4
        stride = self.width * self.channels
        raw, above = zlib.decompress(packed), bytearray(stride)
        self.rows = []
        for y in range(self.height):
            row = bytearray(raw[y * (stride + 1) + 1:(y + 1) * (stride + 1)])
            self._unfilter(raw[y * (stride + 1)], row, above)
            self.rows.append(row)
            above = row

    def _unfilter(self, kind, row, above):
        n = self.channels
        for i in range(len(row) if kind else 0):
            left = row[i - n] if i >= n else 0
            up, corner = above[i], above[i - n] if i >= n else 0
            if kind == 1:
                guess = left
            elif kind == 2:
                guess = up
            elif kind == 3:
                guess = (left + up) // 2
            else: # Paeth
                estimate = left + up - corner
                guess = min((abs(estimate - left), 0, left), (abs(estimate - up), 1, up),
                            (abs(estimate - corner), 2, corner))[2]
            row[i] = (row[i] + guess) & 255

    def at(self, x, y):
        """(r, g, b) of the pixel in column x, row y from the top."""
        return tuple(self.rows[y][self.channels * x:self.channels * x + 3])

    def colours(self):
        """(r, g, b) -> number of pixels."""
        counts = {}
        for row in self.rows:
            for i in range(0, len(row), self.channels):
                colour = bytes(row[i:i + 3])
                counts[colour] = counts.get(colour, 0) + 1
        return {tuple(colour): count for colour, count in counts.items()}
