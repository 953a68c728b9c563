"""References and assignment, from the surface to tables and triangles: BITSTREAM.md, section 7."""
from collections import defaultdict
from itertools import islice
from math import isqrt

from coding import BitModel, IntegerModel, SymbolModel, bits, cross, dot, largest, require, shifted, sub
from connectivity import next_corner, previous_corner


# ---------------------------------------------------------------------------- 7.1 References

class References:
    """Position numbers of the real vertices where several share a position."""

    INSTANCES = 8    # walked of a position
    NEIGHBOURS = 24  # walked around a vertex
    CANDIDATES = 15

    def __init__(self, surface, reader):
        self.surface = surface
        self.reader = reader
        self.number = [None] * surface.vertex_count()  # position number of each vertex
        self.instances = []                            # vertices at each position, the earliest first
        self.copies = [0] * surface.vertex_count()
        self.following, self.preceding = {}, {}
        for c, v in enumerate(surface.vertex):
            if surface.is_dummy(v):
                self.following[surface.next_vertex(c)] = surface.previous_vertex(c)
                self.preceding[surface.previous_vertex(c)] = surface.next_vertex(c)
        self.repeats, self.which, self.back = defaultdict(BitModel), defaultdict(SymbolModel), IntegerModel()

    def run(self):
        for v in self.surface.real_vertices():
            self.place(v, self.decode(v))
        return self.number, len(self.instances)

    def decode(self, v):
        """The position of v."""
        count = len(self.instances)
        if count == 0:
            return 0
        candidates = []
        f = self.along(v, self.following, candidates)
        p = self.along(v, self.preceding, candidates)
        if f is not None or p is not None:
            confidence = 3 if f == p else 2
        else:
            confidence = 1 if candidates else 0
        context = confidence, min(self.copies[v], 2), v in self.following
        if not self.repeats[context].get(self.reader):
            return count
        self.around(v, candidates)
        s = self.which[confidence].get(self.reader)
        if s < len(candidates):
            return candidates[s]
        require(s == 15, "a reference beyond the list")
        back = self.back.get(self.reader)
        require(back < count, "a reference to a position before the first")
        return count - 1 - back

    def position(self, v):
        return None if v is None else self.number[v]

    def latest_instances(self, x):
        return islice(reversed(self.instances[x]), self.INSTANCES)

    def neighbours(self, v):
        return (self.surface.next_vertex(c) for c in self.surface.walk(v))

    def add(self, x, candidates):
        if x is not None and x not in candidates and len(candidates) < self.CANDIDATES:
            candidates.append(x)

    def along(self, v, step, candidates):
        u = step.get(v)
        if self.position(u) is None:
            return None
        result = None
        for w in self.latest_instances(self.position(u)):
            x = None if step.get(w) == v else self.position(step.get(w))
            if result is None and w != u:
                result = x
            self.add(x, candidates)
        return result

    def around(self, v, candidates):
        for u in islice(self.neighbours(v), self.NEIGHBOURS):
            at = self.position(u)
            if at is None or len(self.instances[at]) == 1 or len(candidates) == self.CANDIDATES:
                continue
            for w in self.latest_instances(at):
                if w == u:
                    continue
                self.add(self.position(self.preceding.get(w)), candidates)
                self.add(self.position(self.following.get(w)), candidates)
                for x in islice(self.neighbours(w), self.NEIGHBOURS):
                    self.add(self.position(x), candidates)

    def place(self, v, x):
        if x == len(self.instances):
            self.instances.append([])
        else:
            if len(self.instances[x]) == 1:
                for u in self.neighbours(self.instances[x][0]):
                    self.copies[u] += 1
            for u in self.neighbours(v):
                self.copies[u] += 1
        self.instances[x].append(v)
        self.number[v] = x


def decode_references(header, surface, reader):
    """Position numbers of the vertices, None for dummies, and how many positions there are."""
    if header.has_references:
        return References(surface, reader).run()
    real = surface.real_vertices()
    return [*real] + [None] * (surface.vertex_count() - len(real)), len(real)


# ---------------------------------------------------------------------------- 7.2 Primitives of faces

def decode_primitives(header, surface, reader):
    """The primitive of each face, None for dummy faces."""
    primitive_of = [None] * surface.face_count()
    real = [surface.is_real_face(f) for f in range(surface.face_count())]
    require(sum(real) <= sum(header.triangle_counts), "more real faces than triangles")
    lacking = list(header.triangle_counts)
    edge, escaped, recent = defaultdict(SymbolModel), IntegerModel(), []
    for f in range(surface.face_count()):
        if not real[f]:
            continue
        p = 0
        if header.primitive_count > 1:
            around = [surface.opposite[c] // 3 for c in range(3 * f, 3 * f + 3)]
            around = [(primitive_of[g], g) for g in around if g < f and real[g]]
            near = [p for p, _ in around]
            candidates = sorted(set(near), key=lambda p: (-near.count(p), -max(g for q, g in around if q == p)))
            s = edge[len(near), len(candidates)].get(reader)
            if s < 3:
                require(s < len(candidates), "a primitive beyond the neighbours'")
                p = candidates[s]
            else:
                if s < 15:
                    require(s - 3 < len(recent), "a primitive beyond the recent ones")
                    p = recent[s - 3]
                else:
                    p = escaped.get(reader)
                    require(p < header.primitive_count, "no such primitive")
                if p in recent:
                    recent.remove(p)
                recent.insert(0, p)
                del recent[12:]
        primitive_of[f] = p
        require(lacking[p] > 0, "more faces than a primitive has triangles")
        lacking[p] -= 1
    return primitive_of, lacking


# ---------------------------------------------------------------------------- 7.3 Corners

class ChoiceModel:
    def __init__(self):
        self.choice = [SymbolModel() for _ in range(4)]
        self.back = IntegerModel()


class Tables:
    """Table vertices as they are created; a vertex is a pair (table, number)."""

    STEPS = 32
    CANDIDATES = 14

    def __init__(self, vertex_counts, position_count, reader):
        self.vertex_counts = vertex_counts
        self.positions = [[] for _ in vertex_counts]     # position number of each vertex of each table
        self.at = [[] for _ in range(position_count)]    # vertices at each position, the earliest first
        self.reader = reader

    def position_count(self):
        return len(self.at)

    def new_position(self):
        self.at.append([])
        return len(self.at) - 1

    def create(self, table, position):
        vertices = self.positions[table]
        require(len(vertices) < self.vertex_counts[table], "more vertices than a table has")
        vertices.append(position)
        self.at[position].append((table, len(vertices) - 1))
        return self.at[position][-1]

    def choose(self, position, table, first, excluded, model):
        listed = [first] if first is not None and first != excluded and first[0] == table else []
        complete = True
        for steps, x in enumerate(reversed(self.at[position])):
            if steps == self.STEPS or len(listed) == self.CANDIDATES:
                complete = False
                break
            if x[0] == table and x != first and x != excluded:
                listed.append(x)
        if not listed and complete:
            return self.create(table, position)
        s = model.choice[min(len(listed), 3)].get(self.reader)
        if s == 0:
            return self.create(table, position)
        if s <= len(listed):
            return listed[s - 1]
        require(s == 15, "a vertex beyond the list")
        back = model.back.get(self.reader)
        number = len(self.positions[table]) - 1 - back
        require(number >= 0, "a vertex before the first")
        require(self.positions[table][number] == position, "a vertex at another position")
        return table, number


def scaled_to(v, m):
    return shifted(v, m - bits(largest(v)))


def limited(v):
    return v if largest(v) < 2**24 else scaled_to(v, 24)


class Bends:
    """How sharply the surface bends between two faces."""

    def __init__(self, surface, numbers, points):
        self.normal = {}
        for f in filter(surface.is_real_face, range(surface.face_count())):
            a, b, c = (points[numbers[v]] for v in surface.vertex[3 * f:3 * f + 3])
            u = cross(limited(sub(b, a)), limited(sub(c, a)))
            normal = scaled_to(u, 14) if any(u) else u
            self.normal[f] = normal, isqrt(dot(normal, normal))

    def bend(self, f, g):
        (normal_f, length_f), (normal_g, length_g) = self.normal[f], self.normal[g]
        d = dot(normal_f, normal_g)
        m = (length_f * length_g) >> 10
        return (d < 1004 * m) + (d < 922 * m) + (d < 717 * m)


UNKNOWN, SMOOTH, SEAM = 0, 1, 2


class Fan:
    """The real corners around a vertex and the edges between them."""

    def __init__(self, v, surface, primitive_of, table_of, uses, bends):
        self.corners = []
        self.edges = {}  # (edge, bend) before each real corner
        self.smooth = self.seams = self.bend = 0
        self.boundary = self.tables = False
        after_boundary = after_seam = after_change = None
        for c in surface.walk(v):
            following = surface.turn(c)
            f, g = c // 3, following // 3
            is_real = primitive_of[f] is not None, primitive_of[g] is not None
            if is_real[0]:
                self.corners.append(c)
            place = len(self.corners)
            edge = bend = 0
            if all(is_real):
                bend = bends.bend(f, g)
                self.bend = max(self.bend, bend)
                x, y = uses[previous_corner(c)], uses[next_corner(following)]
                edge = UNKNOWN if x is None or y is None else SMOOTH if x == y else SEAM
                self.smooth += edge == SMOOTH
                self.seams += edge == SEAM
                if edge == SEAM:
                    after_seam = place
                if primitive_of[f] != primitive_of[g]:
                    after_change = place
                    self.tables |= table_of(c) != table_of(following)
            else:
                self.boundary = True
                if is_real[1]:
                    after_boundary = place
            if is_real[1]:
                self.edges[following] = edge, bend
        self.primitives = after_change is not None
        starts = after_boundary, after_seam, after_change, 0
        start, kind = next((start, kind) for kind, start in enumerate(starts) if start is not None)
        self.kind = min(kind, 2)
        if self.corners:
            start %= len(self.corners)
            self.corners = self.corners[start:] + self.corners[:start]


class Corners:
    """The table vertex that each corner of a real face uses."""

    def __init__(self, header, surface, numbers, points, primitive_of, tables, reader):
        self.surface, self.numbers, self.tables, self.reader = surface, numbers, tables, reader
        self.primitive_of = primitive_of
        self.primitive_table = header.primitive_table
        self.table_count = header.table_count
        self.uses = [None] * len(surface.vertex)
        self.bends = Bends(surface, numbers, points)
        self.single, self.continues = defaultdict(BitModel), defaultdict(BitModel)
        self.whole, self.begin, self.other = ChoiceModel(), ChoiceModel(), ChoiceModel()
        self.after = [ChoiceModel() for _ in range(3)]

    def run(self):
        for v in self.surface.real_vertices():
            fan = Fan(v, self.surface, self.primitive_of, self.table_of, self.uses, self.bends)
            if fan.corners:
                self.decode(fan, self.numbers[v])
        for c, vertex in enumerate(self.uses):
            require(vertex is not None or self.primitive_of[c // 3] is None, "a corner that no fan reaches")
        return self.uses

    def table_of(self, c):
        return self.primitive_table[self.primitive_of[c // 3]]

    def decode(self, fan, position):
        corners = fan.corners
        several_tables = fan.tables
        if self.table_count > 1 and fan.boundary:
            several_tables |= any(self.table_of(c) != self.table_of(corners[0]) for c in corners)
        if not several_tables:
            has = bool(self.tables.at[position])
            context = min(fan.seams, 3), min(fan.smooth, 2), fan.boundary, fan.primitives, has, fan.bend
            if self.single[context].get(self.reader):
                vertex = self.tables.choose(position, self.table_of(corners[0]), None, None, self.whole)
                for c in corners:
                    self.uses[c] = vertex
                return
        self.decode_each(fan, position)

    def decode_each(self, fan, position):
        corners = fan.corners
        ahead = fan.seams - (fan.kind == 1)
        found = 0
        first = previous = None
        for i, c in enumerate(corners):
            model, excluded, table = self.begin, None, self.table_of(c)
            if i > 0:
                model = self.other
                edge, bend = fan.edges[c]
                if edge == SEAM and ahead > 0:
                    ahead -= 1
                before = corners[i - 1]
                if table == self.table_of(before):
                    changes = self.primitive_of[c // 3] != self.primitive_of[before // 3]
                    middle = min(abs(2 * i - len(corners)) // 2, 2)
                    context = edge, changes, min(found, 2), fan.kind, ahead > 0, middle, bend
                    if self.continues[context].get(self.reader):
                        self.uses[c] = previous
                        continue
                    model, excluded = self.after[fan.kind], previous
                found += 1
            previous = self.uses[c] = self.tables.choose(position, table, first, excluded, model)
            if first is None:
                first = previous


# ---------------------------------------------------------------------------- 7.4 Side faces and unused vertices

class SideFaces:
    """The triangles that the surface does not have."""

    def __init__(self, header, surface, numbers, primitive_of, lacking, uses, tables, reader):
        self.header, self.surface, self.numbers, self.primitive_of = header, surface, numbers, primitive_of
        self.lacking, self.uses, self.tables, self.reader = lacking, uses, tables, reader
        self.same, self.is_duplicate = BitModel(), BitModel()
        self.primitive, self.duplicate, self.position = IntegerModel(), IntegerModel(), IntegerModel()
        self.index = [IntegerModel() for _ in range(3)]
        self.kind = [SymbolModel() for _ in range(3)]
        self.duplicate_choice = ChoiceModel()
        self.last_primitive = self.last_duplicate = 0
        self.last_index = [0] * header.table_count

    def run(self, triangles):
        has_real_face = any(p is not None for p in self.primitive_of)
        for _ in range(sum(self.lacking)):
            p = 0
            if self.header.primitive_count > 1:
                p = self.last_primitive
                if not self.same.get(self.reader):
                    p = self.relative(self.primitive, p, self.header.primitive_count)
            require(self.lacking[p] > 0, "more side faces than a primitive lacks")
            self.lacking[p] -= 1
            self.last_primitive = p
            table = self.header.primitive_table[p]
            is_duplicate = has_real_face and self.is_duplicate.get(self.reader)
            triangles[p] += self.decode_duplicate(table) if is_duplicate else self.decode_other(table)

    def relative(self, model, reference, limit):
        x = reference + model.signed(self.reader)
        require(0 <= x < limit, "a relative number out of range")
        return x

    def decode_duplicate(self, table):
        f = self.last_duplicate = self.relative(self.duplicate, self.last_duplicate, self.surface.face_count())
        require(self.primitive_of[f] is not None, "a duplicate of a dummy face")
        corners = range(3 * f, 3 * f + 3)
        if self.header.one_vertex_per_position:
            return [self.uses[c][1] for c in corners]
        return [self.tables.choose(self.numbers[self.surface.vertex[c]], table, self.uses[c], None,
                                   self.duplicate_choice)[1] for c in corners]

    def decode_other(self, table):
        triangle = []
        for k in range(3):
            triangle.append(self.decode_vertex(k, triangle, table))
        self.last_index[table] = triangle[0]
        return triangle

    def decode_vertex(self, k, triangle, table):
        tables = self.tables
        positions = tables.positions[table]
        reference = self.last_index[table] if k == 0 else triangle[k - 1]
        s = self.kind[k].get(self.reader)
        if s < 2:
            require(s < k, "a repetition of a vertex to come")
            return triangle[s]
        if s == 2:
            return self.relative(self.index[k], reference, len(positions))
        if s == 3:
            require(not self.header.one_vertex_per_position, "a second vertex at a position")
            near = positions[reference] if reference < len(positions) else 0
            return tables.create(table, self.relative(self.position, near, tables.position_count()))[1]
        require(s == 4, "a side face's vertex of no kind")
        return tables.create(table, tables.new_position())[1]


def decode_unused_vertices(header, tables, reader):
    is_new, distance = BitModel(), IntegerModel()
    for table, vertex_count in enumerate(header.vertex_counts):
        x = 0
        while len(tables.positions[table]) < vertex_count:
            if header.one_vertex_per_position or is_new.get(reader):
                x = tables.new_position()
            else:
                x += distance.signed(reader)
                require(0 <= x < tables.position_count(), "an unused vertex at no position")
            tables.create(table, x)


def decode_assignment(header, surface, numbers, points, reader):
    """Position numbers of each table's vertices, triangles of each primitive, and how many positions there are."""
    primitive_of, lacking = decode_primitives(header, surface, reader)
    tables = Tables(header.vertex_counts, len(points), reader)
    if header.one_vertex_per_position:
        require(header.vertex_counts[0] >= len(points), "fewer vertices than positions")
        for number in range(len(points)):
            tables.create(0, number)
        uses = [None if numbers[v] is None else (0, numbers[v]) for v in surface.vertex]
    else:
        uses = Corners(header, surface, numbers, points, primitive_of, tables, reader).run()
    triangles = [[] for _ in range(header.primitive_count)]
    for f, p in enumerate(primitive_of):
        if p is not None:
            triangles[p] += [vertex for _, vertex in uses[3 * f:3 * f + 3]]
    SideFaces(header, surface, numbers, primitive_of, lacking, uses, tables, reader).run(triangles)
    decode_unused_vertices(header, tables, reader)
    return tables.positions, triangles, tables.position_count()
