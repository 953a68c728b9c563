"""Logistic mixing: BITSTREAM.md, section 6.9.4."""
from coding import clamp, log

KNOTS = [1, 2, 3, 5, 8, 13, 22, 36, 60, 98, 162, 267, 439, 720, 1179, 1921, 3108, 4971, 7812, 11955, 17625, 24743,
         32768, 40793, 47911, 53581, 57724, 60565, 62428, 63615, 64357, 64816, 65097, 65269, 65374, 65438, 65476,
         65500, 65514, 65523, 65528, 65531, 65533, 65534, 65535]


def squash(x):
    i, part = (x + 2816) >> 7, (x + 2816) & 127
    return (KNOTS[i] * (128 - part) + KNOTS[i + 1] * part + 64) >> 7


class Chance:
    def __init__(self):
        self.p = 32768
        self.rate = 32767

    def stretched(self):
        return (log(2 * self.p + 1) - log(131071 - 2 * self.p)) >> 16

    def update(self, bit):
        if bit:
            distance = 65535 - self.p
            self.p = 65535 - (distance - ((distance * self.rate) >> 16))
        else:
            self.p -= (self.p * self.rate) >> 16
        self.rate = max(self.rate - ((self.rate * self.rate) >> 16), 257)


def short(x):
    return clamp(x, -32768, 32767)


class Weights:
    """A weight set: how many weights and what they are at first, the rate at first and at last."""

    def __init__(self, count, first, rate, last_rate):
        self.weight = [first] * count
        self.rate, self.last_rate = rate, last_rate

    def learn(self, inputs, error):
        step = short((error * self.rate) >> 13)
        self.rate -= (self.rate - self.last_rate) >> 6
        for i, x in enumerate(inputs):
            self.weight[i] = short(self.weight[i] + ((((8 * x * step) >> 16) + 1) >> 1))


def mix(sets, inputs):
    """By the weights of all sets together."""
    total = sum(short(sum(weights)) * x for *weights, x in zip(*(s.weight for s in sets), inputs))
    return clamp(total >> 14, -2815, 2815)


def decide(sets, inputs, chances, reader):
    """A bit that the inputs predict; sets and chances learn from it."""
    q = squash(mix(sets, inputs))
    one = clamp(q >> 1, 1, 32767)
    bit = reader.bit(one)
    for weights in sets:
        weights.learn(inputs, 65535 * bit - q)
    for chance in chances:
        chance.update(bit)
    return bit
