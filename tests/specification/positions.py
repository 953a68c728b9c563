"""Lattice positions of the surface's positions: BITSTREAM.md, section 6."""
from collections import defaultdict, deque
from math import isqrt

from coding import (CumulativeTable, IntegerModel, add, add_to_each, average, bits, clamp, cross, dot, largest, log,
                    scale, shift_right, sign, sub, undo_zigzag)
from connectivity import next_corner, previous_corner
from mixed import MixedResiduals, arc_of

PARALLELOGRAM, WEIGHTED, VALENCE, AVERAGE, ADAPTIVE = range(5)
INFINITE = float("inf")
EAGER_UNTIL = 2048  # time until which all learn from each position


# ---------------------------------------------------------------------------- 6.1 The lattice

def on_lattice(v):
    return tuple(clamp(x, -2**26, 2**26) for x in v)


def wrapped(v):
    return tuple((x + 2**27) % 2**28 - 2**27 for x in v)


def short(v):
    return tuple(clamp(x, -2**15, 2**15 - 1) for x in v)


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
        self.point = self.frame = self.offset = None

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

DEFAULT_FRAME = ((4096, 0, 0), (0, 4096, 0), (0, 0, 4096))


def toward_zero(x, n):
    """x / 2^n without its fraction."""
    return sign(x) * (abs(x) >> n)


def each_toward_zero(v, n):
    return tuple(toward_zero(x, n) for x in v)


def rounded(x):
    """To 24 significant bits, ties to even."""
    n = bits(x) - 24
    if n <= 0:
        return x
    m, rest = abs(x) >> n, abs(x) % 2**n
    m += rest > 2**(n - 1) or (rest == 2**(n - 1) and m % 2 == 1)
    return sign(x) * (m << n)


def scaled(v):
    """With 11 bits in the largest component."""
    v = tuple(rounded(x) for x in v)
    n = bits(largest(v)) - 11
    return each_toward_zero(v, n) if n >= 0 else scale(v, 2**-n)


def unit(v):
    square = dot(v, v)
    n = bits(square) - 8
    root = isqrt(2**46 // (((square >> n) + 1) << n))
    return each_toward_zero(scale(v, root), 11)


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
        return normal, first, each_toward_zero(cross(normal, first), 12)
    upright = cross(normal, scaled(sub(prediction.point, base)))
    if not any(upright):
        return DEFAULT_FRAME
    second = unit(scaled(upright))
    return normal, each_toward_zero(cross(second, normal), 12), second


def to_lattice(frame, local):
    return tuple((dot(axis, local) + 2**11) >> 12 for axis in zip(*frame))


# ---------------------------------------------------------------------------- 6.5 The adaptive offset

class AdaptiveOffset:
    """A sum of features, weighted by sign-sign LMS."""

    def __init__(self, vector_shift):
        self.vector_shift = vector_shift            # u
        self.weight = defaultdict(lambda: [0] * 8)  # by class and component
        self.features = None

    def offset(self, p):
        u = self.vector_shift
        left, right, base = p.stencils[0]
        height = add(sub(p.left, p.base), sub(p.right, p.base))
        vectors = [left.surprise, right.surprise, base.surprise, short(shift_right(sub(p.candidates[0], p.point), u)),
                   short(shift_right(height, u + 1)), short(shift_right(sub(p.left, p.right), u))]
        near = [tuple(dot(axis, v) >> (13 if i < 4 else 16) for axis in p.frame) for i, v in enumerate(vectors)]
        left, right, base = (state.valence for state in p.stencils[0])
        self.features = near[:4] + [scale(near[4], 4)]
        self.features.append(scale(near[4], clamp(p.valence - 6, -7, 7)))
        self.features.append(scale(near[5], clamp(left - right, -7, 7)))
        self.features.append(scale(near[4], clamp(left + right - base - 6, -7, 7)))
        offset = []
        for a in range(3):
            total = sum(w * feature[a] for w, feature in zip(self.weight[p.model_class, a], self.features))
            total = (total + 2**13 + 2**31) % 2**32 - 2**31
            offset.append((total >> 14) << u)
        return tuple(offset)

    def learn(self, p, residual):
        for a in range(3):
            weight = self.weight[p.model_class, a]
            for i, feature in enumerate(self.features):
                weight[i] = clamp(weight[i] + 64 * sign(residual[a]) * sign(feature[a]), -32768, 32767)


# ---------------------------------------------------------------------------- 6.6 Residuals

DECAYS = (6, 8, 11, 15, 19, 25, 31, 38, 44, 42)


def first_table(decay):
    """Bins before anything is known."""
    weights = []
    for i in range(16):
        x = 2**14
        for _ in range(abs(i - 8)):
            x = decay * x // 64
        weights.append(64 + x)
    below = [i + 32752 * sum(weights[:i]) // sum(weights) for i in range(17)]
    return CumulativeTable(below, 0, (13312, 21248, 27904))


class Tables(dict):
    """Tables by key, `first_of(key)` before they are first used."""

    def __init__(self, decay_of):
        super().__init__()
        self.decay_of = decay_of

    def __missing__(self, key):
        self[key] = first_table(self.decay_of(*key))
        return self[key]


class Context:
    """The context of each component."""

    def __init__(self, p, header):
        stencils = (p.stencils * 2)[:2]
        magnitudes = [sum(state.magnitude[a] for stencil in stencils for state in stencil) for a in range(3)]
        if p.n == 1:
            apart = [abs(x >> 1) for x in sub(p.left, p.right)]
        else:
            apart = [abs(x) for x in sub(p.candidates[0], p.candidates[1])]
        spread = [min(x, 8192) << (6 - header.fine_bits) for x in apart]
        if header.is_tangent:
            spread = [sum(spread) >> 1] * 3
        self.scale, self.ratio, self.shift = [], [], []
        for own, s in zip(magnitudes, spread):
            mean = 16 * own + sum(magnitudes) + 16
            scale_class = max(0, (log(mean + (s >> 2)) - (9 << 22)) >> 22)
            self.scale.append(scale_class)
            self.shift.append(max(0, scale_class - 6) >> 1)
            ratio = (log(s + 1) - log(mean) + (3 << 23)) >> 23
            self.ratio.append(clamp(ratio, 0, 4) + 5 * p.model_class)


class HitModel:
    def __init__(self):
        self.p = 16384

    def get(self, reader):
        bit = reader.bit(self.p, ends_group=False)
        self.p += ((32737 if bit else 31) - self.p) >> 5
        return bit


class ResidualReader:
    def __init__(self, header, reader):
        self.header = header
        self.reader = reader
        self.step = steps_of(header)
        self.step_bits = [bits(step) - 1 for step in self.step]
        self.second_tells = header.predictor == PARALLELOGRAM
        self.centred = Tables(lambda a, scale_class, ratio: DECAYS[min(scale_class, 9)])
        self.placed = Tables(lambda a, wide, *_: DECAYS[9 if wide else 5])
        self.beyond, self.hit = defaultdict(IntegerModel), defaultdict(HitModel)

    def get(self, p, state):
        """The residual of a position; sets the hits of its state."""
        context = Context(p, self.header)
        candidates = self.candidates(p) if self.header.has_candidates else None
        came_true, flags = 0, [0, 0, 0]
        residual, wanting = [0, 0, 0], [0, 0, 0]
        for a in range(3):
            shift = context.shift[a]
            half = (1 << shift) >> 1
            centred = self.centred[a, context.scale[a], context.ratio[a]]
            if candidates is None:
                value = self.value(a, shift, [centred])
            else:
                bins = [(candidate[a] + half) >> shift for candidate in candidates]
                place = clamp(bins[self.second_tells], -7, 7) + 7 if p.n > 1 else 15
                around = sum(end.hits >> a & 1 for end in p.stencils[0][:2])
                value = self.value(a, shift, [centred, self.placed[a, shift > 0, came_true, around, place]])
                came_true = 1 + bins.index(value) if value in bins else 3
                if self.header.exact_hits:
                    if shift > 0 and came_true < 3:
                        before = flags[a - 1] if a > 0 else 0
                        flags[a] = self.hit[a, min(shift, 3), came_true, around, before].get(self.reader)
            if flags[a]:
                residual[a] = candidates[came_true - 1][a]
            else:
                residual[a] = (value << shift) - half
                wanting[a] = shift
        if sum(wanting) > 11:
            self.reader.end_group()
        for a in range(3):
            residual[a] += self.reader.raw(wanting[a], ends_group=False)
        self.reader.end_group()
        if candidates is not None:
            near = short(residual)
            state.hits = sum((near[a] in (candidates[0][a], candidates[1][a])) << a for a in range(3))
        return residual

    def candidates(self, p):
        """Where the first two candidates lie, as residuals."""
        result = []
        for candidate in (p.candidates * 2)[:2] if p.n == 1 else p.candidates[:2]:
            d = sub(candidate, p.point)
            if self.header.is_tangent:
                d = [dot(axis, short(d)) >> 12 for axis in p.frame]
            d = sub(d, p.offset)
            result.append(short((x + (step >> 1)) >> m for x, step, m in zip(d, self.step, self.step_bits)))
        return result

    def value(self, a, shift, tables):
        """The bin of component a, from the middle."""
        b = self.reader.symbol(average(tables[0], tables[-1]), ends_group=False)
        value = b - 8
        if b in (0, 15):
            self.reader.end_group()
            limit = 2**28 >> (shift + self.step_bits[a])
            value += sign(value) * self.beyond[shift].get(self.reader)
            value = clamp(value, -limit, limit)
        if a == 1 and self.header.exact_hits:
            self.reader.end_group()
        for table in tables:
            table.update(b)
        return value


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
        self.vector_shift = 3 if header.is_tangent and not header.is_max_effort else 0
        self.adaptive = AdaptiveOffset(self.vector_shift)
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
        state.position = wrapped(add(p.point, to_lattice(p.frame, local) if self.header.is_tangent else local))
        state.magnitude = [min(abs(r), 5461) for r in residual]
        state.surprise = short(shift_right(sub(state.position, p.mean), self.vector_shift))

    def residual(self, p, state):
        """By sections 6.5 and 6.6."""
        header = self.header
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
