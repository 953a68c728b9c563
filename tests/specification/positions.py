"""Lattice positions of the surface's positions: BITSTREAM.md, section 6."""
from collections import defaultdict, deque
from math import isqrt

from coding import (BitModel, IntegerModel, add, add_to_each, bits, clamp, cross, dot, largest, log, scale,
                    shift_right, shifted, sign, sub, undo_zigzag, width)
from connectivity import next_corner, previous_corner
from mixed import MixedResiduals, arc_of

PARALLELOGRAM, WEIGHTED, VALENCE, AVERAGE, ADAPTIVE = range(5)
INFINITE = float("inf")
EAGER_UNTIL = 2048  # time until which all learn from each position


# ---------------------------------------------------------------------------- 6.1 The lattice

def on_lattice(v):
    return tuple(clamp(x, -2**26, 2**26) for x in v)


def steps_of(header):
    """Steps of the residuals' components in fine units."""
    return (max(1, 64 // header.normal_scale), 64, 64) if header.is_tangent else (1, 1, 1)


# ---------------------------------------------------------------------------- 6.2 Order and stencils

class State:
    """What is kept of a known position."""

    def __init__(self, valence):
        self.valence = valence
        self.position = None
        self.magnitude = [0, 0, 0]
        self.hits = 0
        self.surprise = (0, 0, 0)


class DegreeOrder:
    """Order 1: vertices with the most parallelograms first."""

    def __init__(self, surface, numbers):
        self.surface = surface
        self.numbers = numbers
        self.places = []                           # position numbers in the order of decoding
        self.placed = set()
        self.met = [False] * surface.vertex_count()
        self.taken = [surface.is_dummy(v) for v in range(surface.vertex_count())]
        self.degree = [0] * surface.vertex_count()
        self.queues = [None, deque(), deque(), deque()]

    def run(self):
        for v in self.surface.real_vertices():
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
        return self.places

    def gain(self, v):
        if not self.taken[v] and self.degree[v] < 3:
            self.degree[v] += 1
            self.queues[self.degree[v]].append(v)

    def place(self, position):
        if position not in self.placed:
            self.placed.add(position)
            self.places.append(position)

    def take(self, v):
        if self.taken[v]:
            return
        surface, met = self.surface, self.met
        self.taken[v] = met[v] = True
        self.place(self.numbers[v])
        for c in surface.walk(v):
            a, b = surface.next_vertex(c), surface.previous_vertex(c)
            beyond = surface.opposite_vertex(previous_corner(c))
            if met[a] and met[b]:
                self.gain(surface.opposite_vertex(c))
                self.gain(beyond)
            if met[a] and met[beyond]:
                self.gain(b)


class Around:
    """What a position finds around it: corners that face the gates of its stencils, and its valence."""

    def __init__(self):
        self.list = []
        self.last_gate = None
        self.valence = 0


def collect_stencils(surface, time, position_count, has_own_order):
    """By time. `has_own_order`: of the positions, which is not that of the vertices."""
    all_around = [Around() for _ in range(position_count)]
    for f in range(surface.face_count()):
        times = [time[3 * f + k] for k in range(3)]
        for t in times:
            if t != INFINITE:
                all_around[t].valence += 1
        if INFINITE in times:
            continue
        k = times.index(max(times)) if has_own_order else 0
        c, t = 3 * f + k, times[k]
        around = all_around[t]
        if sum(other >= t for other in times) > 1 or len(around.list) == 3:
            continue
        around.last_gate = c
        if time[surface.opposite[c]] < t:
            around.list.append(c)
    return all_around


class Prediction:
    """All that sections 6.3 to 6.6 derive from the stencils of one position."""

    def __init__(self, time, corner, stencils, valence):
        self.time = time
        self.corner = corner                   # of the first stencil
        self.stencils = stencils               # triples of states (left, right, base)
        self.valence = valence
        self.n = len(stencils)
        self.model_class = self.n - 1          # `class`
        self.left, self.right, self.base = (state.position for state in stencils[0])
        self.candidates = [sub(add(left.position, right.position), base.position) for left, right, base in stencils]
        self.mean = self.mean_of(*self.candidates)
        self.point = self.frame = self.around = self.offset = None

    @staticmethod
    def mean_of(first, second=None, third=None):
        if second is None:
            return first
        if third is None:
            return add(first, shift_right(add_to_each(sub(second, first), 1), 1))
        both = sub(add(second, third), scale(first, 2))
        return add(first, shift_right(add_to_each(both, 2), 2))


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
    return 65536 // clamp(valence, 3, 255)


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

DEFAULT_FRAME = ((8192, 0, 0), (0, 8192, 0), (0, 0, 8192))


def scaled(v):
    return shifted(v, 14 - width(v))


def unit(v):
    i = dot(v, v) >> 19
    root = isqrt((2 * i + 1) << 18)
    return shift_right(scale(v, 2**28 // root), 15)


def frame_at(prediction, is_tip_aligned):
    """The axes normal, first and second."""
    left, right, base = prediction.left, prediction.right, prediction.base
    gate = scaled(sub(left, right))
    across = cross(gate, scaled(sub(base, right)))
    if not any(across):
        return DEFAULT_FRAME
    normal = unit(scaled(across))
    if not is_tip_aligned:
        first = unit(gate)
        return normal, first, shift_right(cross(normal, first), 13)
    upright = cross(normal, scaled(sub(prediction.point, base)))
    if not any(upright):
        return DEFAULT_FRAME
    second = unit(scaled(upright))
    return normal, shift_right(cross(second, normal), 13), second


def to_lattice(frame, local):
    return tuple((dot(axis, local) + 2**12) >> 13 for axis in zip(*frame))


# ---------------------------------------------------------------------------- 6.5 Displacements and the adaptive offset

class VectorsAround:
    """Vectors around a position, and where its candidates lie."""

    def __init__(self, p, is_tangent):
        left, right, base = p.stencils[0]
        first, second = (sub(candidate, p.point) for candidate in (p.candidates[0], p.candidates[:2][-1]))
        vectors = [left.surprise, right.surprise, base.surprise, first,
                   shift_right(add(sub(p.left, p.base), sub(p.right, p.base)), 1), sub(p.left, p.right), second]
        self.e = 12 - max(map(width, vectors))
        common = [shifted(v, self.e) for v in vectors]
        if is_tangent:
            self.near = [tuple(sum((m * x) >> 16 for m, x in zip(axis, v)) for axis in p.frame) for v in common]
            self.displacements = [shifted(self.near[i], 3 - self.e) for i in (3, 6)]
        else:
            self.near = [shift_right(v, 3) for v in common]
            self.displacements = [first, second]


class AdaptiveOffset:
    """A sum of features, weighted by sign-sign LMS."""

    def __init__(self):
        self.weight = defaultdict(lambda: [0] * 8)  # by class and component
        self.features = None

    def offset(self, p):
        near = p.around.near
        left, right, base = (state.valence for state in p.stencils[0])
        self.features = [scale(near[i], 4) for i in range(5)]
        self.features.append(scale(near[4], clamp(p.valence - 6, -12, 12)))
        self.features.append(scale(near[5], clamp(left - right, -12, 12)))
        self.features.append(scale(near[4], clamp(left + right - base - 6, -12, 12)))
        shift = max(14 + p.around.e, 0)
        offset = []
        for a in range(3):
            total = sum(w * feature[a] for w, feature in zip(self.weight[p.model_class, a], self.features))
            value = (total + (1 << (shift - 1))) >> shift if shift > 0 else total
            offset.append(clamp(value, -2**26, 2**26))
        return tuple(offset)

    def learn(self, p, residual):
        for a in range(3):
            weight = self.weight[p.model_class, a]
            for i, feature in enumerate(self.features):
                weight[i] = clamp(weight[i] + 64 * sign(residual[a]) * sign(feature[a]), -32768, 32767)


# ---------------------------------------------------------------------------- 6.6 Residuals

class BinTable:
    TOTAL = 32736
    DECAYS = (6, 8, 11, 15, 19, 25, 31, 38, 44, 42)

    def __init__(self, bins, scale_class):
        decay = self.DECAYS[min(scale_class, 9)]
        weights = []
        for i in range(bins):
            x = 2**14
            for _ in range(abs(i - bins // 2)):
                x = decay * x // 64
            weights.append(64 + x)
        self.below = [self.TOTAL * sum(weights[:i]) // sum(weights) for i in range(bins)]
        self.age = 0

    def update(self, bin_):
        rate = 3 + (self.age >= 13312) + (self.age >= 21248) + (self.age >= 27904)
        for i in range(1, len(self.below)):
            self.below[i] += ((self.TOTAL if i > bin_ else 0) - self.below[i]) >> rate
        self.age += (32767 - self.age) >> rate

    def window(self, start):
        return [0] + self.below[start + 1:start + 16] + [self.TOTAL]


class Shares:
    """Of the experts of a class and component."""

    def __init__(self):
        self.share = [21845] * 3

    def mixed(self, windows):
        below = [i + sum((w[i] * share) >> 16 for w, share in zip(windows, self.share)) for i in range(16)]
        return below + [32768]

    def learn(self, given):
        part = [(g * share) >> 16 for g, share in zip(given, self.share)]
        r = 2**31 // (1 + sum(part))
        for j in range(3):
            p = (part[j] * r) >> 15
            target = p - (p >> 5) + 682
            self.share[j] += (target - self.share[j]) >> 6


class Context:
    """The context of one component, and where the candidates lie in it."""

    def __init__(self, p, a, fine_bits, step):
        stencils = (p.stencils * 2)[:2]
        magnitudes = [sum(state.magnitude[i] for stencil in stencils for state in stencil) for i in range(3)]
        own, total = magnitudes[a], sum(magnitudes)
        if p.n == 1:
            s = sum(abs(x) >> 2 for x in sub(p.left, p.right))
        else:
            s = sum(abs(d[a]) for d in p.around.displacements)
        spread = min(s, 4096) << (6 - fine_bits)
        expected = 192 * own + 16 * total + 3 * spread + 256
        self.scale = (log(expected) - (8 << 23)) >> 22
        self.shift = max(0, (log(expected) - (11 << 23) - 1677721) >> 23)
        ratio = (log(spread + 1) - log(16 * own + total + 16) + (3 << 23)) >> 23
        self.ratio = clamp(ratio, 0, 4) + 5 * p.model_class
        self.half = (1 << self.shift) >> 1
        self.candidates = [d[a] - p.offset[a] for d in p.around.displacements]
        m = self.shift + bits(step) - 1
        whole = bits(step) - 1
        self.hit_at = [(c + ((1 << whole) >> 1)) >> whole for c in self.candidates]
        self.bins = [clamp((c + ((1 << m) >> 1)) >> m, -8, 8) for c in self.candidates]


class ResidualReader:
    def __init__(self, header, reader):
        self.header = header
        self.reader = reader
        self.step = steps_of(header)
        self.centred, self.shifted = {}, {}
        self.shares = defaultdict(Shares)
        self.beyond, self.hit = defaultdict(IntegerModel), defaultdict(BitModel)

    def get(self, p, state):
        """The residual of a position."""
        residual, wanting = [0, 0, 0], [0, 0, 0]
        for a in range(3):
            context = Context(p, a, self.header.fine_bits, self.step[a])
            value = self.value(p, a, context)
            if self.header.exact_hits and context.shift > 0:
                exact = self.exact_hit(p, a, context, value, state)
                if exact is not None:
                    residual[a] = exact
                    continue
            residual[a] = (value << context.shift) - context.half
            wanting[a] = context.shift
        low = self.reader.long_raw(sum(wanting))
        residual[0] += low >> (wanting[1] + wanting[2])
        residual[1] += (low >> wanting[2]) % (1 << wanting[1])
        residual[2] += low % (1 << wanting[2])
        return residual

    def value(self, p, a, context):
        b = self.bin(p, a, context)
        limit = 2**28 >> (context.shift + bits(self.step[a]) - 1)
        value = b - 8
        if b == 0:
            value = max(value - self.beyond[context.shift].get(self.reader), -limit)
        elif b == 15:
            value = min(value + self.beyond[context.shift].get(self.reader), limit)
        return value

    def bin(self, p, a, context):
        key = a, context.scale, context.ratio
        if key not in self.centred:
            self.centred[key] = BinTable(16, context.scale)
        centred = self.centred[key]
        if p.n == 1 or self.header.centred_only:
            b = self.reader.symbol([i + t for i, t in enumerate(centred.below)] + [32768], a)
            centred.update(b)
            return b
        key = a, context.scale
        if key not in self.shifted:
            self.shifted[key] = BinTable(32, context.scale)
        table = self.shifted[key]
        windows = [centred.window(0)] + [table.window(8 - o) for o in context.bins]
        shares = self.shares[p.model_class, a]
        b = self.reader.symbol(shares.mixed(windows), a)
        if p.time % 4 == a or p.time < EAGER_UNTIL:
            shares.learn([w[b + 1] - w[b] for w in windows])
            table.update(b + 8 - min(context.bins, key=lambda o: abs(b - 8 - o)))
        centred.update(b)
        return b

    def exact_hit(self, p, a, context, value, state):
        left, right, _ = p.stencils[0]
        around_hits = (left.hits >> a & 1) + (right.hits >> a & 1)
        before = state.hits >> (a - 1) & 1 if a > 0 else 0
        for j, candidate in enumerate(context.hit_at[:p.n]):
            if (candidate + context.half) >> context.shift != value or (j == 1 and candidate == context.hit_at[0]):
                continue
            if self.hit[min(context.shift, 8) - 1, j, around_hits, p.model_class, before].get(self.reader):
                state.hits |= 1 << a
                return candidate
        return None


# ---------------------------------------------------------------------------- 6.2 to 6.7 together

class Positions:
    def __init__(self, header, surface, numbers, position_count, reader):
        self.header, self.surface, self.reader = header, surface, reader
        self.places = DegreeOrder(surface, numbers).run() if header.is_degree_order else range(position_count)
        time_of = {position: time for time, position in enumerate(self.places)}
        self.time = [time_of.get(numbers[v], INFINITE) for v in surface.vertex]  # by corner
        self.around = collect_stencils(surface, self.time, position_count,
                                       header.is_degree_order or header.has_references)
        self.states = []                           # by time
        self.step = steps_of(header)
        self.residuals = ResidualReader(header, reader)
        self.mixed = MixedResiduals(header, self.step, reader)
        self.adaptive = AdaptiveOffset()
        self.free = [IntegerModel() for _ in range(3)]

    def run(self):
        """Points by position number."""
        points = [None] * len(self.places)
        for time, position in enumerate(self.places):
            state = State(self.around[time].valence)
            self.decode(time, state)
            self.states.append(state)
            points[position] = state.position
        return points

    def known(self, c):
        """The state of the position at a corner, none before it is known."""
        return self.states[self.time[c]] if self.time[c] < len(self.states) else None

    def decode(self, time, state):
        around = self.around[time]
        if not around.list:
            self.decode_free(around, state)
            return
        corners = arc_of(self.surface, self.time, around.list) if self.header.is_max_effort else around.list
        stencils = [(self.known(next_corner(c)), self.known(previous_corner(c)), self.known(self.surface.opposite[c]))
                    for c in corners]
        p = Prediction(time, corners[0], stencils, around.valence)
        p.point = self.point(p)
        p.frame = frame_at(p, self.header.is_tip_aligned) if self.header.is_tangent else DEFAULT_FRAME
        if self.header.is_max_effort:
            is_centred = self.header.predictor == ADAPTIVE
            residual = self.mixed.decode(self.surface, self.known, corners, p, is_centred, state)
        else:
            residual = self.residual(p, state)
        local = [o + r * step for o, r, step in zip(p.offset, residual, self.step)]
        state.position = on_lattice(add(p.point, to_lattice(p.frame, local) if self.header.is_tangent else local))
        state.magnitude = [min(abs(r), 5461) for r in residual]
        state.surprise = tuple(clamp(x, -32768, 32767) for x in sub(state.position, p.mean))

    def residual(self, p, state):
        """By sections 6.5 and 6.6."""
        header = self.header
        p.around = VectorsAround(p, header.is_tangent)
        p.offset = self.adaptive.offset(p) if header.predictor == ADAPTIVE else (0, 0, 0)
        residual = self.residuals.get(p, state)
        if header.predictor == ADAPTIVE and (p.time % 2 == 1 or p.time < EAGER_UNTIL):
            self.adaptive.learn(p, residual)
        return residual

    def point(self, p):
        """The predicted point (section 6.3)."""
        if self.header.predictor == PARALLELOGRAM:
            return p.candidates[0]
        if self.header.predictor in (AVERAGE, ADAPTIVE):
            return p.mean
        angles = [by_valence(state.valence) for state in p.stencils[0][:2]]
        if self.header.predictor == WEIGHTED:
            gate = next_corner(p.corner), previous_corner(p.corner)
            angles = [self.remaining(g, angle) for g, angle in zip(gate, angles)]
        return on_lattice(weighted(p, angles))

    def remaining(self, g, fallback):
        """What the known angles around a vertex leave to each unknown one (section 6.3)."""
        rest, unknown, d = 65536, 0, g
        for _ in range(32):
            a, b = self.known(next_corner(d)), self.known(previous_corner(d))
            if a and b:
                rest -= inner_angle(self.known(g).position, a.position, b.position)[0]
            else:
                unknown += 1
            d = self.surface.turn(d)
            if d == g:
                break
        return rest // unknown if unknown > 0 and rest > 0 else fallback

    def decode_free(self, around, state):
        """A position without a stencil (section 6.7)."""
        origin = (0, 0, 0)
        if around.last_gate is not None:
            origin = self.known(previous_corner(around.last_gate)).position
        elif self.states:
            origin = self.states[-1].position
        state.position = on_lattice(add(origin, [model.signed(self.reader) for model in self.free]))


def decode_positions(header, surface, numbers, position_count, reader):
    """Lattice coordinates by position number."""
    return Positions(header, surface, numbers, position_count, reader).run()


# ---------------------------------------------------------------------------- 6.8 Extra positions

def decode_extra_positions(header, count, reader):
    models = [[IntegerModel() for _ in range(4)] for _ in range(3)]
    e = header.fine_bits - (1 if header.normal_scale > 1 else 0)
    limit = 2**(26 - e)
    last, length = [0, 0, 0], 0
    extra = []
    for _ in range(count):
        for a in range(3):
            u = models[a][length].get(reader)
            length = min(bits(u) >> 1, 3)
            last[a] = clamp(last[a] + undo_zigzag(u), -limit, limit)
        extra.append(scale(last, 2**e))
    return extra
