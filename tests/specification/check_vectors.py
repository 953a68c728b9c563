#!/usr/bin/env python3
"""The test vectors by the decoder in this folder: streams give the arrays of their JSON files, damaged ones an error.

    check_vectors.py FOLDER
"""
import json
import random
import struct
import sys
from pathlib import Path

from coding import StreamError
from decoder import decode, xxh64

DAMAGED_STREAMS = 200
BYTE_LIMIT = 1 << 20  # of damaged streams' outputs


def as_float32(x):
    return struct.unpack("<f", struct.pack("<f", x))[0]


def same_numbers(found, expected):
    """Whether two nested lists hold the same numbers, floats compared as binary32."""
    if isinstance(found, list) and isinstance(expected, list):
        return len(found) == len(expected) and all(map(same_numbers, found, expected))
    if isinstance(found, float):
        return found == as_float32(expected)
    return found == expected


def faults_of_vector(stream, expected):
    mesh = decode(stream)
    if len(stream) != expected["bytes"] or mesh.header.size != expected["header bytes"]:
        yield f"{len(stream)} bytes, {mesh.header.size} of them header"
    if not same_numbers(mesh.header.values, [field["value"] for field in expected["header"]]):
        yield f"header {mesh.header.values}"
    if f"{mesh.checksum:08x}" != expected["checksum"]:
        yield f"checksum {mesh.checksum:08x}, not {expected['checksum']}"
    if len(mesh.outputs) != len(expected["outputs"]):
        yield f"{len(mesh.outputs)} outputs"
    for found, output in zip(mesh.outputs, expected["outputs"]):
        name = f"output {output['output']}"
        if found.kind != output["kind"] or len(found.data) != output["count"]:
            yield f"{name}: {len(found.data)} {found.kind}"
        if len(found.bytes) != output["byte length"]:
            yield f"{name}: {len(found.bytes)} bytes, not {output['byte length']}"
        if f"{xxh64(found.bytes, 0):016x}" != output["xxh64"]:
            yield f"{name}: XXH64 {xxh64(found.bytes, 0):016x}, not {output['xxh64']}"
        if not same_numbers(found.data, output["data"]):
            yield f"{name}: other numbers"


def damaged(streams):
    """Truncated, bit-flipped and extended streams, the same in every run."""
    chance = random.Random(1)
    names = sorted(streams)
    for i in range(DAMAGED_STREAMS):
        name = names[i % len(names)]
        stream = bytearray(streams[name])
        if i % 4 == 0:
            length = chance.randrange(len(stream))
            yield f"{name} cut to {length} bytes", bytes(stream[:length])
            continue
        bit = chance.randrange(8 * len(stream))
        stream[bit // 8] ^= 1 << bit % 8
        yield f"{name} with bit {bit} flipped", bytes(stream)
    for name in names:
        yield f"{name} with a byte more", streams[name] + bytes(1)


def main(folder):
    streams = {path.stem: path.read_bytes() for path in sorted(folder.glob("*.tsc"))}
    faults = [] if streams else [f"no vectors in {folder}"]
    for name, stream in streams.items():
        try:
            expected = json.loads((folder / f"{name}.json").read_text(encoding="utf-8"))
            faults += [f"{name}: {fault}" for fault in faults_of_vector(stream, expected)]
        except (StreamError, OSError) as error:
            faults.append(f"{name}: {error}")
    refused = 0
    for what, stream in damaged(streams) if streams else ():
        try:
            decode(stream, BYTE_LIMIT)
            faults.append(f"{what}: decoded without an error")
        except StreamError:
            refused += 1
    for fault in faults:
        print(fault, file=sys.stderr)
    print(f"{len(streams)} vectors, {refused} damaged streams refused, {len(faults)} faults")
    return int(bool(faults))


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    sys.exit(main(Path(sys.argv[1])))
