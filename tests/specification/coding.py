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


def undo_zigzag(u):
    return u // 2 if u % 2 == 0 else -(u + 1) // 2


# ---------------------------------------------------------------------------- 3 Entropy coder

LEAST_STATE = 2**56


class EntropyReader:
    """The rANS decoder (section 3). What takes `ends_group` leaves the group open if that is false."""

    def __init__(self, payload):
        require(len(payload) >= 8, "truncated payload")
        self.payload = payload
        self.position = 8
        self.state = int.from_bytes(payload[:8], "big")
        require(self.state >= LEAST_STATE, "an initial state below 2^56")

    def end_group(self):
        while self.state < LEAST_STATE:
            require(self.position < len(self.payload), "truncated payload")
            self.state = self.state * 256 + self.payload[self.position]
            self.position += 1

    def slot(self):
        return self.state % 2**15

    def consume(self, start, frequency, ends_group=True):
        self.state = frequency * (self.state >> 15) + self.slot() - start
        if ends_group:
            self.end_group()

    def symbol(self, below, ends_group=True):
        """The symbol s that owns [below[s], below[s + 1])."""
        s = bisect_right(below, self.slot()) - 1
        self.consume(below[s], below[s + 1] - below[s], ends_group)
        return s

    def bit(self, one, ends_group=True):
        """1 with probability `one` / 2^15."""
        bit = int(self.slot() < one)
        self.consume(0 if bit else one, one if bit else 32768 - one, ends_group)
        return bit

    def raw(self, n, ends_group=True):
        value = self.state % 2**n
        self.state >>= n
        if ends_group:
            self.end_group()
        return value


# ---------------------------------------------------------------------------- 4 Adaptive models

def approach(below, symbol, rate):
    """Moves cumulative frequencies towards a distribution in which `symbol` has nearly all."""
    for s in range(1, 16):
        below[s] += (s + (32752 if s > symbol else 0) - below[s]) >> rate


class SymbolModel:
    """Symbols 0 to 15 (section 4.1)."""

    def __init__(self):
        self.count = 0
        self.below = [2048 * s for s in range(17)]

    def get(self, reader):
        x = reader.symbol(self.below)
        rate = 3 + (self.count >= 4) + (self.count >= 12) + (self.count >= 32)
        approach(self.below, x, rate)
        self.count = min(self.count + 1, 32)
        return x


class BitModel:
    """Section 4.2."""

    def __init__(self):
        self.p = 16384
        self.count = 0

    def get(self, reader):
        bit = reader.bit(self.p)
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


class CumulativeTable:
    """Symbols 0 to 15; the ages from which on it moves more slowly are its stage's (section 4.4)."""

    def __init__(self, below, age, slower_from):
        self.below = list(below)
        self.age = age
        self.slower_from = slower_from

    def update(self, symbol):
        rate = 3 + sum(self.age >= age for age in self.slower_from)
        approach(self.below, symbol, rate)
        self.age += (32767 - self.age) >> rate


def average(a, b):
    """The cumulative frequencies by two tables."""
    return [(x + y) >> 1 for x, y in zip(a.below, b.below)]
