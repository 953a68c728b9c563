"""Tips at effort max: BITSTREAM.md, section 5.7."""
from collections import defaultdict

from coding import bits, clamp
from mixing import Chance, Weights, decide

HASH = 0x9E3779B1
BELOW = [2, 1, 0, 13]
ABOVE = [4, 5, 14, 6, 7, 8, 9, 12, 10, 11, 15]


def excess(classes):
    """How far degrees are above 6."""
    return clamp(sum(classes) - 5 * len(classes), -8, 8) + 8


def level(x):
    return (x >= 5) + (x > 5)


def packed(numbers):
    """(number, width) pairs as one number, the first one highest."""
    result = 0
    for number, width in numbers:
        result = result << width | number
    return result


def contexts_of(gate):
    """The six contexts around a gate."""
    forward = gate.forward
    p = [gate.pivot, gate.beyond_pivot, gate.away(True, 2)]
    q = [gate.other, gate.beyond_other, gate.away(False, 2)]
    big_p, big_q = [node.vertex_class for node in p], [node.vertex_class for node in q]
    u, v = [min(node.free, 15) for node in p], [min(node.free, 15) for node in q]
    o = gate.start.facing
    r = [(p[i + 1] if forward else p[i]).facing for i in range(2)]
    s = [(q[i] if forward else q[i + 1]).facing for i in range(2)]
    m = (u[0] == 1) + (u[0] == 1 and u[1] == 1)
    n = (v[0] == 1) + (v[0] == 1 and v[1] == 1)
    near = excess(big_p[:m + 1] + big_q[:n + 1])
    around = excess(big_p + big_q + [o] + r + s)
    levels = [s[0], r[0], o, big_q[1], big_p[1], big_q[0], big_p[0]]
    return [
        packed((x, 4) for x in (big_p[0], big_q[0], big_p[1], o, r[0], u[0])),
        packed((x, 4) for x in (*big_p, *r, u[0], u[1])),
        packed((x, 4) for x in (*big_q, *s, v[0], v[1])),
        packed([(m, 2), (n, 2), (near, 5)]),
        packed([(m, 2), (n, 2)] + [(level(x), 2) for x in levels]),
        packed([(big_p[0], 4), (big_q[0], 4), (around, 5)] + [(min(x, 3), 2) for x in (v[1], u[1], v[0], u[0])]),
    ]


class Repetition:
    def __init__(self, number_bits):
        self.number_bits = number_bits
        self.symbols = []
        self.last = defaultdict(int)
        self.length = self.source = self.recent = 0

    def note(self, symbol):
        self.length = self.length + 1 if self.length > 0 and self.symbols[self.source] == symbol else 0
        self.source += 1
        self.symbols.append(symbol)
        self.recent = (16 * self.recent + symbol) % 2**32
        i = (self.recent * HASH) % 2**32 >> (32 - self.number_bits)
        if self.length == 0 and self.last[i] > 0:
            self.source, self.length = self.last[i], 1
        self.last[i] = len(self.symbols)


class MixedTips:
    """Decodes the symbols of tips."""

    def __init__(self, vertex_count):
        self.number_bits = clamp(bits(vertex_count), 6, 14)      # M
        self.rare_number_bits = min(self.number_bits, 10)        # N
        self.slots = defaultdict(Chance)                         # by context, number and decision
        self.by_length = defaultdict(Chance)
        self.weights = defaultdict(lambda: Weights(8, 5500, 10000, 1500))
        self.repetition = Repetition(self.number_bits)

    def get(self, gate, reader):
        self.reader = reader
        self.hashes = [(x * HASH) % 2**32 for x in contexts_of(gate)]
        repetition = self.repetition
        self.holds = repetition.length > 0
        self.expected = repetition.symbols[repetition.source] if self.holds else None
        symbol = self.symbol()
        repetition.note(symbol)
        return symbol

    def symbol(self):
        if self.decide(0, self.expected == 3):
            return 3
        if self.decide(1, self.expected in BELOW):
            choices, first, later = BELOW, 2, 4
        else:
            choices, first, later = ABOVE, 3, 6
        for i, x in enumerate(choices[:-1]):
            if self.decide(first if i == 0 else later + i - 1, self.expected == x):
                return x
        return choices[-1]

    def decide(self, d, expected):
        shift = 32 - (self.number_bits if d < 4 else self.rare_number_bits)
        chances = [self.slots[k, h >> shift, d] for k, h in enumerate(self.hashes)]
        inputs = [chance.stretched() for chance in chances]
        if self.holds:
            chances.append(self.by_length[d, min(self.repetition.length, 32), expected])
            inputs.append(chances[-1].stretched())
        else:
            inputs.append(0)
        inputs.append(400)
        bit = decide([self.weights[d]], inputs, chances, self.reader)
        self.holds = self.holds and expected == bit
        return bit
