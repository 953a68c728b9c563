#!/usr/bin/env python3
"""A decoder of tangent-space compressed meshes, written from extension-spec/BITSTREAM.md alone.

It shares nothing with the C++ codec, so that each checks the other and both check the document. It follows the
document section by section and favours being read over being fast:

    coding.py        1.3 arithmetic, 3 entropy coder, 4 adaptive models
    connectivity.py  1.4 corners, 5 connectivity
    mixed_tips.py    5.7 tips at effort max
    positions.py     6 positions
    mixed.py         6.9 positions at effort max
    mixing.py        6.9.4 mixing
    assignment.py    7 references and assignment
    decoder.py       2 header, 8 outputs and checksum

    decoder.py STREAM...    decodes streams and says what they hold
"""
import math
import struct
import sys
from pathlib import Path

from assignment import decode_assignment, decode_references
from coding import EntropyReader, StreamError, require, undo_zigzag
from connectivity import decode_surface
from positions import decode_extra_positions, decode_positions


# ---------------------------------------------------------------------------- 2 Header

FLOAT32 = 5
POSITION_TYPES = {0: "b", 1: "B", 2: "h", 3: "H", FLOAT32: "f"}  # as struct spells them
INDEX_TYPES = "BHI"
LARGEST_FLOAT32 = (2 - 2**-23) * 2.0**127


class HeaderReader:
    """Numbers of the header (section 2.1). `values` gets every field's value in the order of the layout."""

    def __init__(self, stream):
        self.stream = stream
        self.position = 0
        self.values = []

    def take(self, count):
        require(self.position + count <= len(self.stream), "truncated header")
        self.position += count
        return self.stream[self.position - count:self.position]

    def keep(self, value):
        self.values.append(value)
        return value

    def byte(self):
        return self.keep(self.take(1)[0])

    def flags(self, *widths):
        """Fields of the next byte, the lowest first."""
        byte = self.take(1)[0]
        fields = []
        for width in widths:
            fields.append(self.keep(byte & ((1 << width) - 1)))
            byte >>= width
        return fields

    def plain_varint(self):
        value = 0
        for i in range(8):
            byte = self.take(1)[0]
            value |= (byte & 127) << (7 * i)
            if byte < 128:
                require(byte != 0 or i == 0, "a varint with a trailing zero group")
                return value
        raise StreamError("a varint of more than 8 bytes")

    def varint(self, limit, name):
        value = self.keep(self.plain_varint())
        require(value <= limit, f"{name}: {value} is over {limit}")
        return value

    def signed_varint(self):
        return self.keep(undo_zigzag(self.plain_varint()))

    def float32(self, name):
        value = self.keep(struct.unpack("<f", self.take(4))[0])
        require(math.isfinite(value), f"{name} is not finite")
        return value


class Header:
    """Section 2.2."""

    def __init__(self, stream):
        fields = HeaderReader(stream)
        require(fields.byte() == 0, "unsupported version")
        self.read_flags(fields)
        self.normal_scale = 1
        if self.is_tangent:
            self.normal_scale = fields.byte() + 1
            require(self.normal_scale <= 16, "normal scale above 16")
        self.step = 1.0
        if self.position_type == FLOAT32:
            self.step = fields.float32("step")
            require(self.step > 0, "step is not positive")
        if self.is_anchored:
            self.origin = [fields.signed_varint() for _ in range(3)]
            require(max(map(abs, self.origin)) <= 2**48, "anchor over 2^48")
        else:
            self.origin = [fields.float32("origin") for _ in range(3)]
        self.read_counts(fields)
        self.values = fields.values
        self.size = fields.position

    def read_flags(self, fields):
        (self.is_tangent, self.is_tip_aligned, self.predictor, self.is_degree_order, self.exact_hits,
         self.is_max_effort) = fields.flags(1, 1, 3, 1, 1, 1)
        (self.position_type, self.is_anchored, self.has_references, self.one_vertex_per_position,
         self.has_candidates, has_dummies) = fields.flags(3, 1, 1, 1, 1, 1)
        require(self.predictor <= 4, "no such predictor")
        require(self.is_tangent or not self.is_tip_aligned, "a basis in lattice mode")
        require(self.position_type in POSITION_TYPES, "no such position type")
        if self.position_type != FLOAT32:
            require(self.is_anchored and not self.is_tangent, "integers that are not anchored in lattice mode")
        self.dummy_count = None if has_dummies else 0
        require(not self.has_candidates or not self.is_max_effort, "candidates at effort max")
        require(not self.exact_hits or self.has_candidates, "exact hits without candidates")
        self.fine_bits = 6 if self.is_tangent else 0

    def read_counts(self, fields):
        self.table_count = fields.varint(2**20, "table count")
        self.primitive_count = fields.varint(2**20, "primitive count")
        require(self.table_count == 1 or not self.one_vertex_per_position, "several tables, one vertex per position")
        self.vertex_counts = [fields.varint(2**29, "vertex count") for _ in range(self.table_count)]
        self.index_types, self.primitive_table, self.triangle_counts = [], [], []
        for _ in range(self.primitive_count):
            table, index_type = divmod(fields.varint(2**56, "index type"), 4)
            require(index_type <= 2, "no such index type")
            require(table < self.table_count, "no such table")
            require(self.vertex_counts[table] <= 2**(8 * 2**index_type), "more vertices than the index size can number")
            self.index_types.append(INDEX_TYPES[index_type])
            self.primitive_table.append(table)
            self.triangle_counts.append(fields.varint(2**29, "triangle count"))
        self.real_count = sum(self.vertex_counts) + fields.signed_varint()
        if self.dummy_count is None:
            self.dummy_count = fields.varint(2**29, "dummies")
            require(self.dummy_count > 0, "no dummies where there should be some")
        vertices = self.real_count + self.dummy_count
        self.surface_faces = 2 * (vertices - fields.signed_varint())
        most = min(4 * sum(self.triangle_counts), 2**29 // 3)
        require(0 <= self.surface_faces <= most, "number of faces out of range")
        require(0 <= self.real_count and vertices <= 3 * self.surface_faces, "number of vertices out of range")

    def output_bytes(self):
        """Section 2.3."""
        positions = sum(self.vertex_counts) * stride_of(POSITION_TYPES[self.position_type])
        indices = zip(self.triangle_counts, self.index_types)
        return positions + sum(3 * count * struct.calcsize("<" + index_type) for count, index_type in indices)


def stride_of(position_type):
    return -(-struct.calcsize("<3" + position_type) // 4) * 4


# ---------------------------------------------------------------------------- 8 Outputs and checksum

class Output:
    """An array of points or indices, as numbers and as bytes."""

    def __init__(self, kind, data, content):
        self.kind = kind
        self.data = data
        self.bytes = content


def component(header, q, a):
    """Component a of the position q (section 6.1)."""
    if header.position_type != FLOAT32:
        return header.origin[a] + q[a]
    fine_step = header.step * 2.0**-header.fine_bits
    if header.is_anchored:
        x = (float(q[a]) + float(header.origin[a] * 2**header.fine_bits)) * fine_step
    else:
        x = header.origin[a] + float(q[a]) * fine_step
    require(abs(x) <= LARGEST_FLOAT32, "a position beyond binary32")
    return struct.unpack("<f", struct.pack("<f", x))[0]


def positions_output(header, points):
    position_type = POSITION_TYPES[header.position_type]
    layout = "<3" + position_type
    padding = bytes(stride_of(position_type) - struct.calcsize(layout))
    data, content = [], bytearray()
    for q in points:
        point = [component(header, q, a) for a in range(3)]
        try:
            content += struct.pack(layout, *point) + padding
        except struct.error:
            raise StreamError("a position out of its type's range") from None
        data.append(point)
    return Output("positions", data, bytes(content))


def indices_output(index_type, indices):
    return Output("indices", indices, struct.pack(f"<{len(indices)}{index_type}", *indices))


PRIMES = (11400714785074694791, 14029467366897019727, 1609587929392839161, 9650029242287828579, 2870177450012600261)


def xxh64(content, seed):
    """Collet, xxHash specification 0.1.1."""
    p1, p2, p3, p4, p5 = PRIMES
    mask = 2**64 - 1

    def rotate(x, n):
        return ((x << n) | (x >> (64 - n))) & mask

    def word(position, size):
        return int.from_bytes(content[position:position + size], "little")

    def mix(lane, x):
        return rotate((lane + x * p2) & mask, 31) * p1 & mask

    at, end, h = 0, len(content), (seed + p5) & mask
    if end >= 32:
        lanes = [(seed + p1 + p2) & mask, (seed + p2) & mask, seed, (seed - p1) & mask]
        for at in range(0, end - 31, 32):
            lanes = [mix(lane, word(at + 8 * i, 8)) for i, lane in enumerate(lanes)]
        at += 32
        h = sum(rotate(lane, n) for lane, n in zip(lanes, (1, 7, 12, 18))) & mask
        for lane in lanes:
            h = ((h ^ mix(0, lane)) * p1 + p4) & mask
    h = (h + end) & mask
    for at in range(at, end - 7, 8):
        h = (rotate(h ^ mix(0, word(at, 8)), 27) * p1 + p4) & mask
    at = end - end % 8
    if end - at >= 4:
        h = (rotate(h ^ (word(at, 4) * p1 & mask), 23) * p2 + p3) & mask
        at += 4
    for byte in content[at:]:
        h = rotate(h ^ (byte * p5 & mask), 11) * p1 & mask
    h = ((h ^ h >> 33) * p2) & mask
    h = ((h ^ h >> 29) * p3) & mask
    return h ^ h >> 32


def checksum_of(header_bytes, outputs):
    h = xxh64(header_bytes, 0)
    for output in outputs:
        h = xxh64(output.bytes, h)
    return h % 2**32


# ---------------------------------------------------------------------------- 1.2 Order of decoding

class Mesh:
    def __init__(self, header, outputs, checksum):
        self.header = header
        self.outputs = outputs
        self.checksum = checksum


def decode(stream, byte_limit=2**31):
    """The mesh in a stream. Raises StreamError, also if its outputs would have more than `byte_limit` bytes."""
    header = Header(stream)
    require(header.output_bytes() <= byte_limit, "outputs larger than the limit")
    reader = EntropyReader(stream[header.size:])
    surface = decode_surface(header, reader)
    numbers, position_count = decode_references(header, surface, reader)
    points = decode_positions(header, surface, numbers, position_count, reader)
    tables, triangles, position_count = decode_assignment(header, surface, numbers, points, reader)
    points += decode_extra_positions(header, position_count - len(points), reader)
    require(reader.position == len(reader.payload), "trailing data")

    outputs = [positions_output(header, [points[x] for x in table]) for table in tables]
    outputs += [indices_output(index_type, indices) for index_type, indices in zip(header.index_types, triangles)]
    checksum = checksum_of(stream[:header.size], outputs)
    require(reader.state == 2**56 + checksum, "checksum mismatch")
    return Mesh(header, outputs, checksum)


def main(names):
    failed = False
    for name in names:
        try:
            mesh = decode(Path(name).read_bytes())
            arrays = ", ".join(f"{output.kind} {len(output.data)}" for output in mesh.outputs)
            print(f"{name}: {arrays}; checksum {mesh.checksum:08x}")
        except StreamError as error:
            failed = True
            print(f"{name}: {error}", file=sys.stderr)
    return int(failed)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
