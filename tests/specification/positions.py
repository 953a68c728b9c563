"""Lattice positions of the surface's vertices: BITSTREAM.md, section 6."""
from collections import defaultdict, deque
from itertools import islice
from math import isqrt

from coding import (BitModel, IntegerModel, add, add_to_each, bits, clamp, cross, dot, largest, scale, shift_right,
                    sign, sub)
from connectivity import previous_corner

PARALLELOGRAM, WEIGHTED, VALENCE, AVERAGE, ADAPTIVE = range(5)


# ---------------------------------------------------------------------------- 6.1 The lattice

def on_lattice(v):
    return tuple(clamp(x, -2**26, 2**26) for x in v)


def steps_of(header):
    """Steps of the residuals' components in fine units."""
    return (max(1, 64 // header.normal_scale), 64, 64) if header.is_tangent else (1, 1, 1)


# ---------------------------------------------------------------------------- 6.2 Order and stencils

class VertexState:
    """What is kept of a known vertex."""

    def __init__(self, valence):
        self.valence = valence
        self.position = None
        self.magnitude = [0, 0, 0]
        self.hits = 0
        self.surprise = (0, 0, 0)


def traverse(surface, decode):
    """Order 0."""
    for v in surface.real_vertices():
        decode(v)


class DegreeOrder:
    """Order 1: vertices with the most parallelograms first."""

    def __init__(self, surface, decode):
        self.surface = surface
        self.decode = decode
        self.met = [False] * surface.vertex_count()
        self.taken = list(surface.is_dummy)
        self.degree = [0] * surface.vertex_count()
        self.queues = [None, deque(), deque(), deque()]

    def run(self):
        for v in range(self.surface.vertex_count()):
            if self.taken[v]:
                continue
            c = self.surface.vertex_corner[v]
            self.take(v)
            self.take(self.surface.next_vertex(c))
            self.take(self.surface.previous_vertex(c))
            d = 3
            while d > 0:
                if not self.queues[d]:
                    d -= 1
                    continue
                w = self.queues[d].popleft()
                if not self.taken[w] and self.degree[w] == d:
                    self.take(w)
                    d = 3

    def gain(self, v):
        if not self.taken[v] and self.degree[v] < 3:
            self.degree[v] += 1
            self.queues[self.degree[v]].append(v)

    def take(self, v):
        if self.taken[v]:
            return
        surface, met = self.surface, self.met
        self.taken[v] = met[v] = True
        self.decode(v)
        for c in surface.walk(v):
            a, b = surface.next_vertex(c), surface.previous_vertex(c)
            beyond = surface.opposite_vertex(previous_corner(c))
            if met[a] and met[b]:
                self.gain(surface.opposite_vertex(c))
                self.gain(beyond)
            if met[a] and met[beyond]:
                self.gain(b)


class Prediction:
    """All that sections 6.3 to 6.6 derive from the stencils of one vertex."""

    def __init__(self, stencils, gate, valence):
        self.stencils = stencils               # triples of states (left, right, base)
        self.gate = gate                       # the vertices left and right of the first stencil
        self.valence = valence
        self.n = len(stencils)
        self.model_class = min(self.n, 3) - 1  # `class`
        self.left, self.right, self.base = (state.position for state in stencils[0])
        self.candidates = [sub(add(left.position, right.position), base.position) for left, right, base in stencils]
        total = (0, 0, 0)
        for candidate in self.candidates[1:]:
            total = add(total, sub(candidate, self.candidates[0]))
        reciprocal = (262144, 131072, 87381, 65536)[self.n - 1]
        mean_offset = shift_right(add_to_each(scale(total, reciprocal), 2**17), 18)
        self.mean = add(self.candidates[0], mean_offset)
        self.point = self.frame = self.offset = self.local_candidates = None


# ---------------------------------------------------------------------------- 6.3 Predictors

def octant(y, x):
    t = (y << 15) // x
    return (t >> 2) + ((t * (32768 - t) * 2847) >> 30)


def angle_of(y, x):
    if x == 0 and y == 0:
        return 0
    m = abs(x)
    q = octant(y, m) if y <= m else 16384 - octant(m, y)
    return q if x >= 0 else 32768 - q


def sine(t):
    u = t * (32768 - t)
    return ((16 * u) << 15) // (5 * 2**30 - 4 * u)


def cotangent(t):
    t = clamp(t, 256, 32512)
    m = (sine(abs(16384 - t)) << 12) // sine(t)
    return -m if t > 16384 else m


def inner_angle(tip, a, b):
    """The angle at `tip` and its cotangent."""
    u, w = sub(a, tip), sub(b, tip)
    e = bits(max(largest(u), largest(w))) - 17
    if e > 0:
        u, w = shift_right(u, e), shift_right(w, e)
    cosine = dot(u, w)
    normal = cross(u, w)
    s = max(0, bits(largest(normal)) - 24)
    small = shift_right(normal, s)
    length = isqrt(dot(small, small)) << s
    if length == 0:
        return 0, 0
    m = min((abs(cosine) << 12) // length, 262144)
    return angle_of(length, cosine), m if cosine >= 0 else -m


def by_valence(valence):
    return 65536 // max(valence, 3)


def weighted(prediction, gate_angles):
    """The weighted parallelogram, from the angles expected at the gate's ends (paper, eq. 2 to 4)."""
    left, right, base = prediction.left, prediction.right, prediction.base
    at_left, at_right = gate_angles
    total = at_left + at_right + by_valence(prediction.valence)
    at_left, at_right = at_left * 32768 // total, at_right * 32768 // total
    alpha, beta = inner_angle(left, right, base)[1], inner_angle(right, base, left)[1]
    gamma, delta = cotangent(at_left), cotangent(at_right)
    total = gamma + delta
    if total < 256:
        return prediction.candidates[0]

    def ratio(m):
        return sign(m) * ((abs(m) << 12) // total)

    w1, w2 = ratio(beta + delta), ratio(alpha + gamma)
    if abs(w1) > 32768 or abs(w2) > 32768:
        return prediction.candidates[0]
    weighted_sum = add(scale(sub(left, base), w1), scale(sub(right, base), w2))
    return add(base, shift_right(add_to_each(weighted_sum, 2**11), 12))


# ---------------------------------------------------------------------------- 6.4 Frames

DEFAULT_FRAME = ((16384, 0, 0), (0, 16384, 0), (0, 0, 16384))


def scaled_to(v, m):
    s = m - bits(largest(v))
    return scale(v, 1 << s) if s >= 0 else shift_right(v, -s)


def limited(v):
    return v if largest(v) < 2**24 else scaled_to(v, 24)


def unit(v):
    if not any(v):
        return v
    w = scaled_to(v, 24)
    r = 2**44 // isqrt(dot(w, w))
    return shift_right(add_to_each(scale(w, r), 2**29), 30)


def cross_unit(a, b):
    return shift_right(add_to_each(cross(a, b), 2**13), 14)


def frame_at(prediction, is_tip_aligned):
    """The axes normal, first and second."""
    left, right, base = prediction.left, prediction.right, prediction.base
    normal = unit(cross(limited(sub(left, right)), limited(sub(base, right))))
    if not any(normal):
        return DEFAULT_FRAME
    if not is_tip_aligned:
        first = unit(limited(sub(left, right)))
        return normal, first, cross_unit(normal, first)
    second = unit(cross(normal, limited(sub(prediction.point, base))))
    if not any(second):
        return DEFAULT_FRAME
    return normal, cross_unit(second, normal), second


def to_lattice(frame, local):
    return tuple((dot(axis, local) + 2**13) >> 14 for axis in zip(*frame))


def to_local(frame, d):
    return tuple((dot(axis, d) + 2**13) >> 14 for axis in frame)


# ---------------------------------------------------------------------------- 6.5 The adaptive offset

class AdaptiveOffset:
    """A sum of features, weighted by sign-sign LMS."""

    def __init__(self):
        self.weight = defaultdict(lambda: [0] * 8)  # by class and component
        self.local = None

    def offset(self, p):
        left, right, base = p.stencils[0]
        height = tuple(int(x / 2) for x in add(sub(p.left, p.base), sub(p.right, p.base)))
        features = [left.surprise, right.surprise, base.surprise, sub(p.candidates[0], p.mean), height, height,
                    sub(p.left, p.right), height]
        factors = [4, 4, 4, 4, 4, clamp(p.valence - 6, -12, 12), clamp(left.valence - right.valence, -12, 12),
                   clamp(left.valence + right.valence - base.valence - 6, -12, 12)]
        common = 12 - max(bits(x if x >= 0 else -x - 1) for feature in features for x in feature)
        scaled = [scale(f, 1 << common) if common >= 0 else shift_right(f, -common) for f in features]
        self.local = [[factor * sum((x * y) >> 16 for x, y in zip(feature, axis))
                       for factor, feature in zip(factors, scaled)] for axis in p.frame]
        shift = 13 + common
        offset = []
        for a in range(3):
            total = dot(self.weight[p.model_class, a], self.local[a])
            value = (total + (1 << (shift - 1))) >> shift if shift > 0 else total << -shift
            offset.append(clamp(value, -2**26, 2**26))
        return tuple(offset)

    def learn(self, p, a, residual):
        weight = self.weight[p.model_class, a]
        for i in range(8):
            w = weight[i] + 16 * sign(residual) * sign(self.local[a][i])
            if abs(w) <= 8000:
                weight[i] = w


# ---------------------------------------------------------------------------- 6.6 Residuals

class BinTable:
    TOTAL = 32736
    INITIAL = [0, 32, 66, 104, 149, 203, 273, 368, 504, 703, 1006, 1472, 2201, 3351, 5174, 8073, 12695, 20072, 24694,
               27593, 29416, 30566, 31295, 31762, 32064, 32264, 32399, 32494, 32564, 32618, 32663, 32701]

    def __init__(self):
        self.below = list(self.INITIAL)
        self.count = 0

    def update(self, bin_):
        rate = 3 + (self.count >= 4) + (self.count >= 12) + (self.count >= 40)
        for i in range(1, 32):
            self.below[i] += ((self.TOTAL if i > bin_ else 0) - self.below[i]) >> rate
        self.count = min(self.count + 1, 63)

    def window(self, offset):
        return [0] + [self.below[i + 8 - offset] for i in range(1, 16)] + [self.TOTAL]


class Mixture:
    """Shares of the experts of a class and component."""

    def __init__(self, expert_count):
        self.share = [65535 // expert_count] * expert_count
        self.least = 2048 // expert_count

    def get(self, windows, reader):
        """A bin, and what each expert has given it."""
        below = [0] + [i + sum((w[i] * share) >> 16 for w, share in zip(windows, self.share)) for i in range(1, 16)]
        b = reader.symbol(below + [32768])
        given = [w[b + 1] - w[b] for w in windows]
        part = [(g * share) >> 8 for g, share in zip(given, self.share)]
        r = (2**32 - 1) // (1 + sum(part))
        for j in range(len(windows)):
            p = (part[j] * r) >> 16
            target = p - (p >> 5) + self.least
            self.share[j] += (target - self.share[j]) >> 6
        return b, given


class Context:
    """The context of one component."""

    def __init__(self, p, around, a, spread, gate_length):
        everywhere = ((around[0] + around[1] + around[2]) * 5461) >> 14  # `all`
        expected = 5 + ((369 * around[a] + 92 * everywhere + (102 * spread if p.n >= 2 else 0)) >> 8)
        w = bits(expected)
        self.scale = min(2 * w + ((expected >> (w - 2)) & 1) - 6, 43)
        self.shift = min(bits(expected // 96), 19)
        s = spread if p.n >= 2 else gate_length >> 2
        t = (4 * around[a] + everywhere) // 5 + 2
        self.ratio = (4 * s >= t) + (2 * s >= t) + (s >= t) + (s >= 2 * t) + 5 * (min(p.n, 3) - 1)
        self.half = (1 << self.shift) >> 1


class ResidualReader:
    def __init__(self, header, reader):
        self.header = header
        self.reader = reader
        self.step = steps_of(header)
        self.base, self.single, self.wide = defaultdict(BinTable), defaultdict(BinTable), defaultdict(BinTable)
        self.mixtures = {}
        self.beyond, self.hit = defaultdict(IntegerModel), defaultdict(BitModel)

    def candidates_of(self, p):
        """Candidates in local coordinates, C[j]."""
        if not self.header.is_tangent:
            return [sub(candidate, p.point) for candidate in p.candidates[:2]]
        local = [to_local(p.frame, sub(p.candidates[0], p.point))]
        if p.n == 2 and p.point == p.mean:
            local.append(scale(local[0], -1))
        elif p.n >= 2:
            local.append(to_local(p.frame, sub(p.candidates[1], p.point)))
        return local

    def in_steps(self, x, a):
        m = ((2 * abs(x) + self.step[a]) * (2**31 // self.step[a])) >> 32
        return m if x >= 0 else -m

    def context(self, p, a):
        def magnitude(stencil, component):
            return sum(state.magnitude[component] for state in stencil)

        spread = gate_length = None
        if p.n == 1:
            around = [(5461 * magnitude(p.stencils[0], i)) >> 10 for i in range(3)]
            length = sum(abs(x) for x in sub(p.left, p.right))
            gate_length = (((16 * length) >> self.header.fine_bits) * 5461) >> 14
        else:
            around = [(2731 * (magnitude(p.stencils[0], i) + magnitude(p.stencils[1], i))) >> 10 for i in range(3)]
            first, second = (abs(local[a]) for local in p.local_candidates)
            spread = min(((first + second) * (65536 // self.step[a])) >> 13, 2**21)
        return Context(p, around, a, spread, gate_length)

    def get(self, p, a, state):
        """The residual of component a."""
        context = self.context(p, a)
        candidates = [self.in_steps(local[a] - p.offset[a], a) for local in p.local_candidates]
        value = self.bin(p, a, context, candidates) - 8
        if value == -8:
            value -= self.beyond[context.shift].get(self.reader)
        elif value == 7:
            value += self.beyond[context.shift].get(self.reader)
        if context.shift == 0:
            return clamp(value, -2**28, 2**28)
        if self.header.exact_hits:
            exact = self.exact_hit(p, a, context, candidates, value, state)
            if exact is not None:
                return exact
        low = self.reader.raw(context.shift)
        return clamp((value << context.shift) + low - context.half, -2**28, 2**28)

    def bin(self, p, a, context, candidates):
        experts = [(self.base[a, context.shift, context.ratio], 0)]
        if self.header.is_max_effort:
            experts.append((self.wide[a, context.scale], 0))
        general = len(experts)
        if p.n >= 2:
            single = self.single[a, context.scale]
            experts += [(single, clamp((c + context.half) >> context.shift, -8, 8)) for c in candidates]
        if (p.model_class, a) not in self.mixtures:
            self.mixtures[p.model_class, a] = Mixture(len(experts))
        windows = [table.window(offset) for table, offset in experts]
        b, given = self.mixtures[p.model_class, a].get(windows, self.reader)
        learning = experts[:general]
        if p.n >= 2:
            learning.append(experts[general if given[general] >= given[general + 1] else general + 1])
        for table, offset in learning:
            table.update(clamp(b + 8 - offset, 0, 31))
        return b

    def exact_hit(self, p, a, context, candidates, value, state):
        left, right, _ = p.stencils[0]
        around_hits = (left.hits >> a & 1) + (right.hits >> a & 1)
        before = state.hits >> (a - 1) & 1 if a > 0 else 0
        for j, candidate in enumerate(candidates):
            if (candidate + context.half) >> context.shift != value or (j == 1 and candidate == candidates[0]):
                continue
            if self.hit[min(context.shift, 8) - 1, j, around_hits, p.model_class, before].get(self.reader):
                state.hits |= 1 << a
                return candidate
        return None


# ---------------------------------------------------------------------------- 6.2 to 6.7 together

class Positions:
    def __init__(self, header, surface, numbers, position_count, reader):
        self.header, self.surface, self.numbers, self.reader = header, surface, numbers, reader
        self.states = [None] * position_count
        self.step = steps_of(header)
        self.residuals = ResidualReader(header, reader)
        self.adaptive = AdaptiveOffset()
        self.free = [IntegerModel() for _ in range(3)]
        self.last = (0, 0, 0)

    def run(self):
        if self.header.is_degree_order:
            DegreeOrder(self.surface, self.decode).run()
        else:
            traverse(self.surface, self.decode)
        return [state.position for state in self.states]

    def known(self, v):
        """The state of a vertex, none before it is known."""
        return None if self.numbers[v] is None else self.states[self.numbers[v]]

    def decode(self, v):
        if self.known(v):
            return
        stencils, gate, neighbour, valence = self.stencils(v)
        state = VertexState(valence)
        if stencils:
            self.decode_by_stencils(Prediction(stencils, gate, valence), state)
        else:
            self.decode_free(neighbour, state)
        self.last = state.position
        self.states[self.numbers[v]] = state

    def stencils(self, v):
        stencils, gate, neighbour, valence = [], None, None, 0
        for c in self.surface.walk(v):
            ends = self.surface.next_vertex(c), self.surface.previous_vertex(c)
            left, right = map(self.known, ends)
            base = self.known(self.surface.opposite_vertex(c))
            if right:
                neighbour = right
                if left and base and len(stencils) < 4:
                    gate = gate or ends
                    stencils.append((left, right, base))
            valence += 1
        return stencils, gate, neighbour, min(valence, 255)

    def decode_by_stencils(self, p, state):
        header = self.header
        p.point = self.point(p)
        p.frame = frame_at(p, header.is_tip_aligned) if header.is_tangent else DEFAULT_FRAME
        p.offset = self.adaptive.offset(p) if header.predictor == ADAPTIVE else (0, 0, 0)
        p.local_candidates = self.residuals.candidates_of(p)
        local = []
        for a in range(3):
            residual = self.residuals.get(p, a, state)
            state.magnitude[a] = min(abs(residual), 16383)
            if header.predictor == ADAPTIVE and residual != 0:
                self.adaptive.learn(p, a, residual)
            local.append(clamp(p.offset[a] + residual * self.step[a], -2**28, 2**28))
        state.position = on_lattice(add(p.point, to_lattice(p.frame, local) if header.is_tangent else local))
        state.surprise = sub(state.position, p.mean)

    def point(self, p):
        """The predicted point (section 6.3)."""
        if self.header.predictor == PARALLELOGRAM:
            return p.candidates[0]
        if self.header.predictor in (AVERAGE, ADAPTIVE):
            return p.mean
        angles = [by_valence(state.valence) for state in p.stencils[0][:2]]
        if self.header.predictor == WEIGHTED:
            angles = [self.remaining(g, angle) for g, angle in zip(p.gate, angles)]
        return on_lattice(weighted(p, angles))

    def remaining(self, g, fallback):
        """What the known angles around a vertex leave to each unknown one (section 6.3)."""
        rest, unknown = 65536, 0
        for c in islice(self.surface.walk(g), 32):
            a, b = self.known(self.surface.next_vertex(c)), self.known(self.surface.previous_vertex(c))
            if a and b:
                rest -= inner_angle(self.known(g).position, a.position, b.position)[0]
            else:
                unknown += 1
        return rest // unknown if unknown > 0 and rest > 0 else fallback

    def decode_free(self, neighbour, state):
        """A vertex without a stencil (section 6.7)."""
        origin = neighbour.position if neighbour else self.last
        state.position = on_lattice(add(origin, [model.signed(self.reader) for model in self.free]))


def decode_positions(header, surface, numbers, position_count, reader):
    """Lattice coordinates by position number."""
    return Positions(header, surface, numbers, position_count, reader).run()


# ---------------------------------------------------------------------------- 6.8 Extra positions

def decode_extra_positions(count, reader):
    models = [IntegerModel() for _ in range(3)]
    last = (0, 0, 0)
    extra = []
    for _ in range(count):
        last = on_lattice(add(last, [model.signed(reader) for model in models]))
        extra.append(last)
    return extra
