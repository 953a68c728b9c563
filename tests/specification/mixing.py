"""Logistic mixing: BITSTREAM.md, section 6.9.4."""
from coding import clamp, dot

KNOTS = [1, 2, 3, 5, 8, 13, 22, 36, 60, 98, 162, 267, 439, 720, 1179, 1921, 3108, 4971, 7812, 11955, 17625, 24743,
         32768, 40793, 47911, 53581, 57724, 60565, 62428, 63615, 64357, 64816, 65097, 65269, 65374, 65438, 65476,
         65500, 65514, 65523, 65528, 65531, 65533, 65534, 65535]


def squash(x):
    i, part = (x + 2816) >> 7, (x + 2816) & 127
    return (KNOTS[i] * (128 - part) + KNOTS[i + 1] * part + 64) >> 7


def stretch_table():
    table, x = [], -2815
    for i in range(4096):
        while x < 2815 and squash(x) < 16 * i:
            x += 1
        table.append(x)
    return table


STRETCH = stretch_table()


class Chance:
    def __init__(self):
        self.p = 32768
        self.count = 0

    def stretched(self):
        return STRETCH[self.p >> 4]

    def update(self, bit):
        rate = 655360 // (10 * self.count + 16)
        if bit:
            self.p += ((65535 - self.p) * rate) >> 16
        else:
            self.p -= (self.p * rate) >> 16
        self.count = min(self.count + 1, 255)


class Weights:
    def __init__(self, count=16):
        self.weight = [251658] * count
        self.rate = 1920

    def mix(self, inputs):
        total = sum(clamp(w >> 6, -32768, 32767) * x for w, x in zip(self.weight, inputs))
        return clamp(total >> 14, -2815, 2815)

    def learn(self, inputs, error):
        step = (error * self.rate) >> 12
        for i, x in enumerate(inputs):
            w = self.weight[i] + ((x * step + 128) >> 8)
            self.weight[i] = (w + 2**31) % 2**32 - 2**31
        self.rate -= (self.rate - 384) >> 6


class FinalWeights:
    def __init__(self):
        self.weight = [32768, 32768]

    def mix(self, pair):
        return clamp(dot(self.weight, pair) >> 16, -2815, 2815)

    def learn(self, pair, error):
        for i in range(2):
            self.weight[i] = clamp(self.weight[i] + ((pair[i] * error + 65536) >> 17), -2**20, 2**20)
