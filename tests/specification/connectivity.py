"""The surface and its growth from the stream: BITSTREAM.md, sections 1.4 and 5."""
from collections import defaultdict

from coding import BitModel, CumulativeTable, IntegerModel, SymbolModel, average, bits, clamp, require
from mixed_tips import MixedTips


# ---------------------------------------------------------------------------- 1.4 Corners

def next_corner(c):
    return c - 2 if c % 3 == 2 else c + 1


def previous_corner(c):
    return c + 2 if c % 3 == 0 else c - 1


class Surface:
    """A closed triangle manifold as a corner table (section 1.4), dummies included."""

    def __init__(self, real_count):
        self.vertex = []         # of each corner
        self.opposite = []       # of each corner
        self.vertex_corner = {}  # of each vertex
        self.real_count = real_count
        self.real = self.dummies = 0  # how many there are so far

    def vertex_count(self):
        return self.real + self.dummies

    def is_dummy(self, v):
        return v >= self.real_count

    def face_count(self):
        return len(self.vertex) // 3

    def next_vertex(self, c):
        return self.vertex[next_corner(c)]

    def previous_vertex(self, c):
        return self.vertex[previous_corner(c)]

    def opposite_vertex(self, c):
        return self.vertex[self.opposite[c]]

    def is_real_face(self, f):
        return not any(self.is_dummy(v) for v in self.vertex[3 * f:3 * f + 3])

    def real_vertices(self):
        return range(self.real_count)

    def turn(self, c):
        return next_corner(self.opposite[next_corner(c)])

    def walk(self, v):
        """The corners around v."""
        first = c = self.vertex_corner[v]
        while True:
            yield c
            c = self.turn(c)
            if c == first:
                return

    def add_vertex(self, corner):
        self.real += 1
        self.vertex_corner[self.real - 1] = corner
        return self.real - 1

    def add_dummy(self, corner):
        vertex = self.real_count + self.dummies
        self.dummies += 1
        self.vertex_corner[vertex] = corner
        return vertex

    def add_face(self, a, b, c):
        """Returns the face's corner 0."""
        self.vertex += [a, b, c]
        self.opposite += [None] * 3
        return len(self.vertex) - 3

    def glue(self, a, b):
        self.opposite[a] = b
        self.opposite[b] = a


# ---------------------------------------------------------------------------- 5.1 The front

DUMMY_CLASS = 15


def class_of(degree):
    return min(degree, 15) - 1


class Node:
    """An edge of the front and the vertex at which it starts."""

    def __init__(self, number, vertex, vertex_class, free):
        self.number = number
        self.vertex = vertex
        self.vertex_class = vertex_class
        self.free = free
        self.queue = None
        self.next = self.previous = self.corner = self.facing = None


def link(a, b):
    a.next = b
    b.previous = a


class Front:
    def __init__(self):
        self.nodes = {}                           # by number
        self.free_numbers = []                    # a stack
        self.number_count = 0                     # C
        self.queues = [{}, {}, {}, {}]            # dictionaries stand for queues: they keep the order of insertion

    def new_node(self, vertex, vertex_class, free):
        if self.free_numbers:
            number = self.free_numbers.pop()
        else:
            number = self.number_count
            self.number_count += 1
        node = self.nodes[number] = Node(number, vertex, vertex_class, free)
        return node

    def leave_queue(self, node):
        if node.queue is not None:
            del self.queues[node.queue][node]
            node.queue = None

    def enter_queue(self, node):
        """Puts a node where its free valence belongs; it keeps its place if that is the queue it is in."""
        queue = min(node.free, 3)
        if node.vertex_class == DUMMY_CLASS and queue > 0:
            queue = None
        if queue == node.queue:
            return
        self.leave_queue(node)
        if queue is not None:
            self.queues[queue][node] = True
            node.queue = queue

    def first_in(self, queue):
        return next(iter(self.queues[queue]), None)

    def remove(self, node):
        self.leave_queue(node)
        self.free_numbers.append(node.number)
        del self.nodes[node.number]


# ---------------------------------------------------------------------------- 5.2 Growing

class Gate:
    """The edge that a pivot's new face is on."""

    def __init__(self, pivot):
        self.pivot = pivot
        self.forward = pivot.previous.vertex_class >= pivot.next.vertex_class
        if self.forward:
            self.other = pivot.next
            self.start, self.end = pivot, self.other
            self.beyond_pivot, self.beyond_other = pivot.previous, self.other.next
        else:
            self.other = pivot.previous
            self.start, self.end = self.other, pivot
            self.beyond_pivot, self.beyond_other = pivot.next, self.other.previous

    def away(self, on_pivot_side, distance):
        """The node so many steps away from the gate (section 5.4)."""
        node = self.pivot if on_pivot_side else self.other
        for _ in range(distance):
            node = node.previous if on_pivot_side == self.forward else node.next
        return node


class Growth:
    """Grows a surface with the header's R real vertices, D dummies and F faces."""

    def __init__(self, real_count, dummy_count, face_count, is_max_effort, reader):
        self.real_count = real_count
        self.dummy_count = dummy_count
        self.face_count = face_count
        self.reader = reader
        self.surface = Surface(real_count)
        self.front = Front()
        self.tips = (MixedTips if is_max_effort else TipModel)(real_count + dummy_count)
        self.start_degree, self.split_distance, self.split_side = SymbolModel(), SymbolModel(), BitModel()
        self.dummy_degree, self.large_degree = IntegerModel(), IntegerModel()
        self.right = [IntegerModel() for _ in range(16)]

    def run(self):
        front = self.front
        while self.surface.face_count() < self.face_count:
            if not front.nodes:
                self.start_component()
            elif front.queues[0]:
                self.close(front.first_in(0))
            else:
                pivot = front.first_in(1) or front.first_in(2) or front.first_in(3)
                require(pivot, "only dummies are left on the front")
                self.extend(pivot)
        require(not front.nodes, "the front is not empty after the last face")
        require(self.surface.face_count() == self.face_count, "more faces than the header says")
        require(self.surface.real == self.real_count, "fewer vertices than the header says")
        require(self.surface.dummies == self.dummy_count, "fewer dummies than the header says")
        return self.surface

    def start_component(self):
        surface = self.surface
        require(self.real_count - surface.real >= 3, "no vertices left for a component")
        degrees = []
        for _ in range(3):
            degree = self.start_degree.get(self.reader)
            if degree == 15:
                degree += self.large_degree.get(self.reader)
            require(degree >= 2, "a component starts with a degree below 2")
            degrees.append(degree)
        corner = surface.add_face(None, None, None)
        nodes = []
        for k in range(3):
            surface.vertex[corner + k] = surface.add_vertex(corner + k)
            node = self.front.new_node(surface.vertex[corner + k], class_of(degrees[k]), degrees[k] - 2)
            nodes.append(node)
            self.front.enter_queue(node)
        link(nodes[1], nodes[0])
        link(nodes[0], nodes[2])
        link(nodes[2], nodes[1])
        for k, facing in ((1, 2), (2, 0), (0, 1)):
            nodes[k].corner = corner + facing
            nodes[k].facing = nodes[facing].vertex_class

    def close(self, node):
        """The face between the two edges of a node of free valence 0."""
        before, after = node.previous, node.next
        require(before is not after, "a loop of two edges is closed")
        last = before.free == 0 or after.free == 0
        if last:
            require(after.next is before and before.free == after.free, "a sector has too few faces")
        if after.vertex > before.vertex:
            at_after = self.surface.add_face(after.vertex, before.vertex, node.vertex)
            at_before = at_after + 1
        else:
            at_before = self.surface.add_face(before.vertex, node.vertex, after.vertex)
            at_after = at_before + 2
        at_node = next_corner(at_before)
        self.surface.glue(at_before, node.corner)
        self.surface.glue(at_after, before.corner)
        if last:
            self.surface.glue(at_node, after.corner)
            self.front.remove(before)
            self.front.remove(after)
        else:
            link(before, after)
            before.corner = at_node
            before.facing = node.vertex_class
            before.free -= 1
            self.front.enter_queue(before)
            after.free -= 1
            self.front.enter_queue(after)
        self.front.remove(node)

    def extend(self, pivot):
        """The face on the pivot's gate."""
        front, surface, gate = self.front, self.surface, Gate(pivot)
        start, end, other = gate.start, gate.end, gate.other
        corner = surface.add_face(None, start.vertex, end.vertex)
        symbol = self.tips.get(gate, self.reader)
        if symbol == TIP_ON_FRONT:
            split, right = self.decode_split(gate)
            tip = front.new_node(split.vertex, split.vertex_class, split.free - 2 - right)
            link(split.previous, tip)
            link(start, split)
            split.free = right
            front.enter_queue(split)
        else:
            degree = self.decode_degree(symbol)
            is_dummy = symbol == TIP_DUMMY
            if is_dummy:
                require(surface.dummies < self.dummy_count, "more dummies than the header says")
                vertex = surface.add_dummy(corner)
            else:
                require(surface.real < self.real_count, "more vertices than the header says")
                vertex = surface.add_vertex(corner)
            tip = front.new_node(vertex, DUMMY_CLASS if is_dummy else class_of(degree), degree - 2)
            link(start, tip)
        link(tip, end)
        surface.vertex[corner] = tip.vertex
        surface.glue(corner, start.corner)
        start.corner, start.facing = corner + 2, end.vertex_class
        tip.corner, tip.facing = corner + 1, start.vertex_class
        other.free -= 1
        front.enter_queue(other)
        front.enter_queue(tip)
        pivot.free -= 1
        if pivot.free == 0:
            self.close(pivot)
        else:
            front.enter_queue(pivot)

    def decode_degree(self, symbol):
        """The degree of a new vertex (section 5.3, Symbols)."""
        if symbol < TIP_LARGE:
            return symbol + 3
        if symbol == TIP_LARGE:
            return 15 + self.large_degree.get(self.reader)
        return 2 if symbol == TIP_DEGREE_2 else 2 + self.dummy_degree.get(self.reader)

    def decode_split(self, gate):
        """A node of the front and its edges on the right (section 5.4)."""
        distance = self.split_distance.get(self.reader)
        if distance > 0:
            split = gate.away(bool(self.split_side.get(self.reader)), distance)
        else:
            split = self.front.nodes.get(self.reader.raw(bits(self.front.number_count - 1)))
            require(split, "a split at a number that is not on the front")
        right = 0
        if split.free > 2:
            right = self.right[min(split.free - 2, 15)].get(self.reader)
        require(split is not gate.start and split is not gate.end, "a split at the gate itself")
        require(split.free >= 2 and right <= split.free - 2, "a split at a node with too few free edges")
        return split, right


# ---------------------------------------------------------------------------- 5.3 The tip

TIP_LARGE, TIP_DEGREE_2, TIP_ON_FRONT, TIP_DUMMY = 12, 13, 14, 15

PRIOR = [0, 1200, 4200, 11200, 20800, 26000, 28200, 29300, 29900,
         30300, 30600, 30800, 31000, 31300, 31400, 32200, 32768]


SLOWER_FROM = 17920, 26624, 31744, 32512


class TipModel:
    """Averages two tables that are chosen by hashes of their contexts."""

    def __init__(self, vertex_count):
        self.number_bits = clamp(bits(vertex_count), 6, 12)  # M
        self.parents = defaultdict(lambda: CumulativeTable(PRIOR, 13000, SLOWER_FROM))
        self.sets = ({}, {})

    def number(self, context):
        return (context * 0x9E3779B1) % 2**32 >> (32 - self.number_bits)

    def get(self, gate, reader):
        pivot, other = gate.pivot, gate.other
        beyond_pivot = gate.beyond_pivot.vertex_class
        facing = (gate.beyond_pivot if gate.forward else pivot).facing
        parent = pivot.vertex_class * 16 + other.vertex_class
        first = (parent << 12) + (gate.beyond_other.vertex_class << 8) + beyond_pivot * 16 + gate.start.facing
        second = (parent << 16) + (facing << 12) + (beyond_pivot << 8) + min(pivot.free, 15) * 16 + min(other.free, 15)
        tables = [self.parents[parent]]
        for tables_by_number, context in zip(self.sets, (first, second)):
            number = self.number(context)
            if number not in tables_by_number:
                tables_by_number[number] = CumulativeTable(tables[0].below, 4096, SLOWER_FROM)
            tables.append(tables_by_number[number])
        symbol = reader.symbol(average(*tables[1:]))
        for table in tables:
            table.update(symbol)
        return symbol


def decode_surface(header, reader):
    """The stage of section 5."""
    return Growth(header.real_count, header.dummy_count, header.surface_faces, header.is_max_effort, reader).run()
