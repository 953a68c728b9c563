"""Positions at effort max: BITSTREAM.md, section 6.9."""
from collections import defaultdict
from math import isqrt

from coding import add, bits, clamp, dot, largest, shift_right, sub
from connectivity import next_corner, previous_corner
from mixing import Chance, Weights, decide

# ---------------------------------------------------------------------------- 6.9.1 The arc

def arc_of(surface, time, corners):
    """The corners of the stencils, chained where the right of one is the left of another."""
    arc = list(corners)

    def follows(c, before):
        return time[previous_corner(before)] == time[next_corner(c)]

    for j in range(len(arc)):
        rest = arc[j:]
        if j == 0:
            starts = [i for i, c in enumerate(rest) if not any(follows(c, d) for d in rest if d != c)]
        else:
            starts = [i for i, c in enumerate(rest) if follows(c, arc[j - 1])]
        i = j + starts[0] if starts else j
        arc[i], arc[j] = arc[j], arc[i]
    return arc


# ---------------------------------------------------------------------------- 6.9.2 Features

def lengths(vectors):
    shift = 0 if max(map(largest, vectors)) < 2**25 else 6
    small = [shift_right(v, shift) for v in vectors]
    return [isqrt(dot(v, v)) << shift for v in small]


def height_of(stencil):
    left, right, base = (state.position for state in stencil)
    return shift_right(add(sub(left, base), sub(right, base)), 1)


def beside(stencil):
    left, right, base = stencil
    return [height_of(stencil), sub(left.position, right.position), base.surprise, right.surprise]


def bends(surface, known, corner, stencil):
    """How the surface bends over the base triangle's other edges."""
    left, right, base = (state.position for state in stencil)
    at_base = surface.opposite[corner]
    result = []
    for c, gate in ((next_corner(at_base), sub(right, left)), (previous_corner(at_base), sub(left, right))):
        wing = known(surface.opposite[c])
        result.append(add(sub(wing.position, base), gate) if wing else (0, 0, 0))
    return result


class Features:
    """Feature vectors in the frame, each component scaled; `known` gives the state at a corner."""

    def __init__(self, surface, known, arc, p, to_local, is_tangent):
        left, right, base = gate = p.stencils[0]
        zero = (0, 0, 0)
        height, across = height_of(gate), sub(left.position, right.position)
        vectors = [base.surprise, left.surprise, right.surprise, zero]
        vectors += [height, across, *bends(surface, known, arc[0], gate)]
        sizes = [zero] * 8
        if is_tangent:
            l = lengths([across, sub(left.position, base.position), sub(right.position, base.position), height])
            sizes[:3] = (0, 0, l[0]), (0, 0, l[1] + l[2]), (0, l[1] - l[2], l[3])
        others = []
        if p.n == 2:
            others = beside(p.stencils[1]) + bends(surface, known, arc[1], p.stencils[1]) + [zero, zero]
        elif p.n == 3:
            others = beside(p.stencils[1]) + beside(p.stencils[2])
        vectors = [to_local(v) for v in vectors] + sizes + [to_local(v) for v in others]
        self.surprise = vectors[:3]
        self.count = len(vectors)
        factors = (p.valence - 6, left.valence - right.valence, left.valence + right.valence - base.valence - 6)
        self.common, self.x = [], []
        for a in range(3):
            component = [v[a] for v in vectors]
            common = 15 - max(bits(x if x >= 0 else -x - 1) for x in component)
            x = [max(scaled_by(f, common), -32767) for f in component]
            for i, factor in enumerate(factors):
                x[12 + i] = (x[5 if i == 1 else 4] * (clamp(factor, -7, 7) << 12)) >> 16
            self.common.append(common)
            self.x.append(x)


def scaled_by(x, n):
    return x << n if n >= 0 else x >> -n


# ---------------------------------------------------------------------------- 6.9.3 Least squares

class Component:
    def __init__(self):
        self.weight = [0] * 24
        self.moment = [[0] * 24 for _ in range(24)]
        self.with_value = [0] * 24

    def predict(self, x, common):
        total = sum((self.weight[i] * x[i] + self.weight[i + 1] * x[i + 1]) >> 5 for i in range(0, len(x), 2))
        shift = 8 + common
        return clamp((total + (1 << (shift - 1))) >> shift if shift > 0 else total << -shift, -2**26, 2**26)

    def accumulate(self, x, y, rate):
        for i, one in enumerate(x):
            row = self.moment[i]
            for j, other in enumerate(x):
                row[j] += (one * other - row[j]) >> rate
            self.with_value[i] += (one * y - self.with_value[i]) >> rate

    def descend(self, i, count, ridge):
        slope = (self.with_value[i] << 13) - dot(self.moment[i][:count], self.weight)
        step = abs(slope) // (self.moment[i][i] + ridge)
        self.weight[i] = clamp(self.weight[i] + (step if slope >= 0 else -step), -32767, 32767)


class LeastSquares:
    """The predictor of one shape class."""

    def __init__(self):
        self.seen = self.turn = self.phase = 0
        self.components = [Component() for _ in range(3)]

    def predict(self, f):
        return [self.components[a].predict(f.x[a], f.common[a]) for a in range(3)]

    def learn(self, f, value):
        self.seen = min(self.seen + 1, 512)
        self.phase = (self.phase + 1) % 4
        few = self.seen < 128
        which = []
        if few:
            which = range(f.count)
        elif self.phase == 3:
            self.turn = self.turn + 8 if self.turn + 8 < f.count else 0
            which = range(self.turn, self.turn + 8)
        for a, component in enumerate(self.components):
            if few or self.phase % 2 == 1:
                y = clamp(scaled_by(value[a], f.common[a]), -32767, 32767)
                component.accumulate(f.x[a], y, min(9, bits(self.seen)))
            for i in which:
                component.descend(i, f.count, 1 + 2**18 // self.seen)


# ---------------------------------------------------------------------------- 6.9.5 Residuals

class Evidence:
    def __init__(self):
        self.unit = 0
        self.predictions = {}  # number: (value in sixteenths, context)
        self.voters = 0
        self.contexts = []
        self.sets = ()


def distance_class(distance, shift):
    x = abs(distance) >> (shift + 1)
    w = bits(x)
    octaves = x if x < 2 else min(2 * (w - 1) + (x >> (w - 2) & 1), 11)
    return (distance >= 0, octaves)


class ResidualMixer:
    def __init__(self, reader, is_tangent):
        self.reader = reader
        self.is_tangent = is_tangent
        self.by_distance, self.by_context, self.by_votes = (defaultdict(Chance) for _ in range(3))
        self.by_scale, self.by_hits = (defaultdict(lambda: Weights(16, 2000, 3000, 1500)) for _ in range(2))

    def get(self, evidence):
        self.evidence = evidence
        self.prediction = {k: value for k, (value, _) in evidence.predictions.items()}
        self.side = 0
        unit = evidence.unit
        negative = not self.decide(0, 0, unit)
        if negative:
            self.prediction = {k: -16 - value for k, value in self.prediction.items()}
            self.side = 1
        doublings = 0
        while unit + doublings < 24:
            if not self.decide(1 + min(doublings, 9), 1 << (unit + doublings), unit + max(doublings - 1, 0)):
                break
            doublings += 1
        top = unit + doublings
        m = 2**23 + self.reader.raw(29) if top == 24 else self.below(doublings, top)
        return -1 - m if negative else m

    def below(self, doublings, top):
        low, width = (0, top) if doublings == 0 else (1 << (top - 1), top - 1)
        first = depth = 0
        while width > 0:
            near = any(low <= (value + 8) >> 4 < low + (1 << width) for value in self.prediction.values())
            if depth >= 1 and not near:
                return low + self.reader.raw(width)
            width -= 1
            d = min(doublings, 7)
            node = 11 + d if depth == 0 else 19 + 2 * d + first if depth == 1 else 35 + min(width, 12)
            upper = self.decide(node, low + (1 << width), width)
            low += upper << width
            if depth == 0:
                first = upper
            depth += 1
        return low

    def decide(self, node, boundary, shift):
        """Whether the magnitude is at least `boundary`."""
        e = self.evidence
        edge = 16 * boundary - 8
        chances = {}
        votes = [0, 0, 0]
        for k, value in self.prediction.items():
            cell = k, e.predictions[k][1], node, distance_class(value - edge, shift)
            chances[k] = self.by_distance[cell]
            votes[(k + 2) // 3] += value >= edge
        if not self.is_tangent:
            chances[7] = self.by_votes[e.voters, *votes, node]
        for k, context in enumerate(e.contexts):
            chances[(4 if self.is_tangent else 8) + k] = self.by_context[k, context, node, self.side]
        inputs = [chances[i].stretched() if i in chances else 0 for i in range(16)]
        if not self.is_tangent:
            inputs[12] = 256
        sets = self.by_scale[min(node, 20), e.sets[0]], self.by_hits[min(node, 20), e.sets[1]]
        return decide(sets, inputs, chances.values(), self.reader)


# ---------------------------------------------------------------------------- 6.9.6 Contexts

class Scale:
    """How large residuals of a component are expected to be."""

    def __init__(self, around, everywhere, spread, several):
        self.around, self.spread = around, spread
        expected = 5 + ((369 * around + 92 * everywhere + (102 * spread if several else 0)) >> 8)
        w = bits(expected)
        half = (expected >> (w - 2)) & 1
        self.unit = min(bits(expected // 96), 19)
        self.fine = min(2 * w + half - 6, 11) if self.unit == 0 else 12 + half
        self.coarse = self.fine // 3


def signed_class(x, size):
    c = (8 * abs(x) >= size) + (2 * abs(x) >= size) + (4 * abs(x) >= 5 * size)
    return 3 - c if x < 0 else 3 + c


def match_class(a, matches):
    return 0 if a == 0 else 1 if matches == 0 else 2 if matches == a else 3


class MixedResiduals:
    """Predicts and decodes the residuals of one vertex after another."""

    def __init__(self, header, step, reader):
        self.header, self.step = header, step
        self.mixer = ResidualMixer(reader, header.is_tangent)
        self.least_squares = defaultdict(LeastSquares)

    def sixteenths(self, x, a):
        m = ((32 * min(abs(x), 2**26) + self.step[a]) * (2**31 // self.step[a])) >> 32
        m = min(m, 2**28)
        return -m if x < 0 else m

    def decode(self, surface, known, arc, p, is_centred, state):
        """The residual of a position. Sets the offset that it counts from, and the state's hits."""
        def to_local(d):
            return tuple((dot(axis, d) + 2**11) >> 12 for axis in p.frame)

        features = Features(surface, known, arc, p, to_local, self.header.is_tangent)
        shape = p.n, (p.valence >= 6) + (p.valence > 6)
        fitted = self.least_squares[shape].predict(features)
        p.offset = fitted if is_centred else (0, 0, 0)
        other = to_local(sub(p.mean, p.point)) if is_centred else fitted
        local = [to_local(sub(candidate, p.point)) for candidate in p.candidates]
        around = p.stencils[0]
        neighbours = [] if self.header.is_tangent else [to_local(sub(s.position, p.point)) for s in around]
        scales = self.scales(p, local)
        matches = [0] * 6
        residuals = []
        for a in range(3):
            e = Evidence()
            e.unit = scales[a].unit
            size = scales[a].coarse
            e.predictions[0] = self.sixteenths(other[a] - p.offset[a], a), size * 3 + p.model_class
            e.voters = p.n
            named = {j: local[j] for j in range(e.voters)} | {3 + k: x for k, x in enumerate(neighbours)}
            named = {k: self.sixteenths(x[a] - p.offset[a], a) for k, x in named.items()}
            for k, value in named.items():
                if k >= 3 or p.n > 1:
                    e.predictions[1 + k] = value, size * 4 + match_class(a, matches[k])
            e.contexts = self.contexts(p, a, scales, residuals, features.surprise)
            e.sets = scales[a].fine, (a * 3 + p.model_class) * 4 + state.hits
            limit = 2**28 >> (self.step[a].bit_length() - 1)
            residual = clamp(self.mixer.get(e), -limit, limit)
            residuals.append(residual)
            for k, x in named.items():
                if abs(x - 16 * residual) <= 8:
                    matches[k] += 1
                    state.hits |= 1 << a
        values = [clamp(p.offset[a] + residuals[a] * self.step[a], -2**28, 2**28) for a in range(3)]
        self.least_squares[shape].learn(features, values)
        return residuals

    def scales(self, p, local):
        used = [state for stencil in p.stencils[:2] for state in stencil]
        around = [(sum(s.magnitude[a] for s in used) * (5461 if p.n == 1 else 2731)) >> 10 for a in range(3)]
        everywhere = (sum(around) * 5461) >> 14
        if p.n == 1:
            gate = sum(abs(x) for x in sub(p.left, p.right))
            spread = [(((gate * 16) >> self.header.fine_bits) * 5461) >> 16] * 3
        else:
            spread = [((abs(local[0][a]) + abs(local[1][a])) * (65536 // self.step[a])) >> 13 for a in range(3)]
        return [Scale(around[a], everywhere, min(spread[a], 2**21), p.n > 1) for a in range(3)]

    def contexts(self, p, a, scales, residuals, surprises):
        size = scales[a].around + 8
        coded = [signed_class(16 * residuals[b], scales[b].around + 4) if b < a else 0 for b in range(2)]
        s, t, u = (signed_class(16 * x[a], size * self.step[a]) for x in surprises)
        spread = scales[a].spread
        w = bits(spread)
        octaves = 2 * w + (spread >> (w - 2) & 1 if w > 1 else 0)
        return [(a, *coded), (s, t, u), (min(octaves, 24), scales[a].fine), (min(p.valence, 12), scales[a].fine)]
