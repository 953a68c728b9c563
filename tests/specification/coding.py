"""Arithmetic, entropy coder and adaptive models: BITSTREAM.md, sections 1.3, 3 and 4."""
from bisect import bisect_right


class StreamError(Exception):
    """The stream is invalid (section 9)."""


def require(condition, message):
    if not condition:
        raise StreamError(message)


# ---------------------------------------------------------------------------- 1.3 Notation and arithmetic

def bits(n):
    return n.bit_length()


def log(x):
    """2^23 times the binary logarithm, linear between powers of two."""
    e = bits(x) - 1
    return (e << 23) + ((x - (1 << e)) << (23 - e))


def clamp(x, low, high):
    return low if x < low else high if x > high else x


def sign(x):
    return (x > 0) - (x < 0)


def add(a, b):
    return tuple(x + y for x, y in zip(a, b))


def sub(a, b):
    return tuple(x - y for x, y in zip(a, b))


def scale(a, m):
    return tuple(x * m for x in a)


def shift_right(a, n):
    return tuple(x >> n for x in a)


def add_to_each(a, n):
    return tuple(x + n for x in a)


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def largest(a):
    """max|a| of section 1.3."""
    return max(map(abs, a))


def shifted(a, n):
    return scale(a, 1 << n) if n >= 0 else shift_right(a, -n)


def width(a):
    return max(bits(x if x >= 0 else -x - 1) for x in a)


def undo_zigzag(u):
    return u // 2 if u % 2 == 0 else -(u + 1) // 2


# ---------------------------------------------------------------------------- 3 Entropy coder

class EntropyReader:
    """The rANS decoder (section 3)."""

    def __init__(self, payload):
        self.payload = payload
        self.position = 0
        self.state = [0, 0, 0]
        for lane in range(3):
            high = self.word()
            self.state[lane] = high << 16 | self.word()
            require(high > 0, "an initial state below 2^16")

    def word(self):
        require(self.position + 2 <= len(self.payload), "truncated payload")
        self.position += 2
        return int.from_bytes(self.payload[self.position - 2:self.position], "little")

    def slot(self, lane=0):
        return self.state[lane] & 32767

    def consume(self, start, frequency, lane=0):
        state = frequency * (self.state[lane] >> 15) + self.slot(lane) - start
        self.state[lane] = state if state >= 1 << 16 else state << 16 | self.word()

    def symbol(self, below, lane=0):
        """The symbol s that owns [below[s], below[s + 1])."""
        s = bisect_right(below, self.slot(lane)) - 1
        self.consume(below[s], below[s + 1] - below[s], lane)
        return s

    def raw(self, n):
        value = 0
        for done in range(0, n, 14):
            m = min(14, n - done)
            part = self.slot() >> (15 - m)
            self.consume(part << (15 - m), 1 << (15 - m))
            value += part << done
        return value

    def long_raw(self, n):
        value = 0
        while n > 14:
            value = (value << 14) + self.raw(14)
            n -= 14
        return (value << n) + self.raw(n)


# ---------------------------------------------------------------------------- 4 Adaptive models

def approach(below, symbol, rate, top):
    """Moves inner cumulative frequencies towards a distribution in which `symbol` has nearly all."""
    for s in range(1, len(below) - 1):
        below[s] += (s + (top if s > symbol else 0) - below[s]) >> rate


class SymbolModel:
    """Symbols 0 to 15 (section 4.1)."""

    def __init__(self):
        self.count = 0
        self.below = [2048 * s for s in range(17)]

    def get(self, reader):
        x = reader.symbol(self.below)
        rate = 3 + (self.count >= 4) + (self.count >= 12) + (self.count >= 32)
        approach(self.below, x, rate, 32752)
        self.count = min(self.count + 1, 32)
        return x


class BitModel:
    """Section 4.2."""

    def __init__(self):
        self.p = 16384
        self.count = 0

    def get(self, reader):
        bit = int(reader.slot() < self.p)
        if bit:
            reader.consume(0, self.p)
        else:
            reader.consume(self.p, 32768 - self.p)
        rate = 2 + (self.count >> 1) if self.count < 4 else 4 if self.count < 16 else 5
        self.p += ((32737 if bit else 31) - self.p) >> rate
        self.count = min(self.count + 1, 16)
        return bit


class IntegerModel:
    """Unsigned integers below 2^30, or signed ones by zigzag (section 4.3)."""

    def __init__(self):
        self.length = SymbolModel()
        self.long_length = SymbolModel()
        self.second = [BitModel() for _ in range(31)]

    def get(self, reader):
        n = self.length.get(reader)
        if n == 15:
            n = 15 + self.long_length.get(reader)
        if n < 2:
            return n
        b = self.second[n].get(reader)
        return ((2 + b) << (n - 2)) + reader.raw(n - 2)

    def signed(self, reader):
        return undo_zigzag(self.get(reader))
