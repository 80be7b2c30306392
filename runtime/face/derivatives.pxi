# Derivatives of a model's functions along directions, in blocks of lanes.

REACTIONS = frozenset(("reactions", "contact_reactions", "impulse_reactions"))
"""Functions that give forces of joints."""

cdef void take_columns(const real *tangents, Py_ssize_t rows, Py_ssize_t lanes, Py_ssize_t count, const Py_ssize_t *places,
                       Py_ssize_t side, Py_ssize_t apart, real *out) noexcept nogil:
    """The first rows of blocks, (rows, count, side): of columns whose first entries are at ``places``, of as many states
    ``side`` by side whose blocks begin ``apart``."""
    cdef Py_ssize_t i, j, k
    for i in range(rows):
        for j in range(count):
            for k in range(side):
                out[(i * count + j) * side + k] = tangents[k * apart + places[j] + i * lanes]


cdef Py_ssize_t[::1] places_of(const Py_ssize_t[::1] columns, Py_ssize_t every, Py_ssize_t lanes):
    """Where ``columns``, lanes of all blocks by number, begin in blocks (.., every, lanes)."""
    cdef Py_ssize_t j
    cdef Py_ssize_t[::1] found = np.empty(columns.shape[0], dtype=np.intp)
    for j in range(columns.shape[0]):
        found[j] = columns[j] // lanes * every * lanes + columns[j] % lanes
    return found


@cython.final
cdef class _Zeros:
    """As many as an argument that does not move has wanted until now."""

    cdef const real[::1] values
    cdef Py_ssize_t count


cdef class Differentiating(Contacting):
    """A model's kernels and their derivatives."""

    @property
    def derivatives(self):
        """Names of the functions whose derivatives the model has and which do not vanish, and how many numbers each has; None
        for a model that was not asked for with them."""
        cdef int i
        if self.m.derivatives is NULL:
            return None
        return {self.m.derivatives.tangents[i].name.decode(): self.m.derivatives.tangents[i].outputs
                for i in range(self.m.derivatives.count)}

    @property
    def directions(self):
        """Directions of a block."""
        return self.m.derivatives.lanes if self.m.derivatives is not NULL else 0

    cdef const real *_given_directions(self, dict by, str name, int blocks, int size, list kept) except NULL:
        """Directions (blocks, size, lanes) in an argument; zeros where there are none."""
        cdef const real[:, :, ::1] given
        cdef const real[::1] none
        value = by.get(name)
        if value is None or not size or not blocks:
            none = self._no_directions(blocks, size, kept)
            return &none[0]
        given = value
        if given.shape[0] != blocks or given.shape[1] != size or given.shape[2] != self.m.derivatives.lanes:
            raise ValueError(f"found directions {value.shape} in {name}, expected {blocks}, {size}, {self.directions}")
        kept.append(value)
        return &given[0, 0, 0]

    cdef const real[::1] _no_directions(self, int blocks, int size, list kept):
        """Zeros for as many directions, the same for all arguments that want no more."""
        cdef Py_ssize_t wanted = max(blocks * size * self.m.derivatives.lanes, 1)
        if not kept or not isinstance(kept[0], _Zeros):
            kept.insert(0, _Zeros())
        cdef _Zeros found = kept[0]
        if found.count < wanted:
            found.values, found.count = zeros(wanted), wanted
            kept.append(found.values)
        return found.values

    cdef directions _along(self, dict by, int blocks, list kept) except *:
        """Directions by argument: the first block and an array of blocks (count, size, lanes). With t come inputs."""
        cdef directions found
        cdef int i
        memset(&found, 0, sizeof(found))
        found.blocks = blocks
        arrays = {name: value for name, (_, value) in by.items()}
        for i, name in enumerate(("q", "u", "k", "t")):
            if name in by:
                found.first[i], found.count[i] = by[name][0], by[name][1].shape[0]
                if found.first[i] < 0 or found.first[i] + found.count[i] > blocks:
                    raise ValueError(f"found blocks from {found.first[i]} in {name}, expected those of {blocks}")
        found.by.q = self._given_directions(arrays, "q", found.count[0], self.m.nu, kept)
        found.by.u = self._given_directions(arrays, "u", found.count[1], self.m.nu, kept)
        found.by.k = self._given_directions(arrays, "k", found.count[2], self.m.constants, kept)
        found.by.t = self._given_directions(arrays, "t", found.count[3], 1, kept)
        found.by.inputs = self._given_directions(arrays, "inputs", found.count[3], self.m.inputs, kept)
        return found

    def constant_tangents(self, const real[:, :, ::1] p):
        """Tangents (blocks, constants, lanes) of the constants along those of the parameters, (blocks, parameters, lanes)."""
        cdef int blocks = p.shape[0], lanes = self.m.derivatives.lanes
        cdef ccgen_arguments at, by
        found = zeros((blocks, self.m.constants, lanes))
        cdef real[:, :, ::1] out = found
        memset(&at, 0, sizeof(at))
        memset(&by, 0, sizeof(by))
        if self.m.parameters and blocks:
            at.k, by.k = &self.k[0], &p[0, 0, 0]
            find_tangent(self.m, b"constants").function(&at, &by, blocks, &out[0, 0, 0])
        return found

    def acceleration_tangents(self, const real[:, ::1] q, const real[:, ::1] u, t, const real[:, ::1] u_dot,
                              const real[:, ::1] multipliers, dict by, int blocks):
        """Tangents (b, blocks, n + rows, lanes) of accelerations and multipliers along directions ``by``, the same for all
        states: of each argument the first block and an array (count, size, lanes); what rows miss by (b,), negative where nothing was in the way; and outcomes by state where there are none."""
        cdef Py_ssize_t i, b = q.shape[0]
        cdef list kept = []
        cdef directions moved = self._along(by, blocks, kept)
        cdef _Times times = _Times(t, b)
        cdef _Memory memory = _Memory()
        cdef system s = self._system(memory)
        cdef int outcome
        found, missed = empty((b, blocks, self.m.nu + self.m.rows, self.m.derivatives.lanes)), empty(b)
        cdef real[:, :, :, ::1] out = found
        cdef real[::1] miss = missed
        without = {}
        for i in range(b):
            outcome = acceleration_tangents(&s, times.at(i), &q[i, 0], &u[i, 0], &u_dot[i, 0],
                                            &multipliers[i, 0] if self.m.rows else NULL, &moved,
                                            &out[i, 0, 0, 0], &miss[i])
            if outcome:
                without[i] = OUTCOMES[outcome]
        return found, missed, without

    cdef ccgen_arguments _whole(self, dict by, int blocks, Py_ssize_t contacts, list kept) except *:
        """Directions (blocks, size, lanes) in all arguments of a function; of the contacts' forces as many as there are."""
        cdef ccgen_arguments moved
        moved.k = self._given_directions(by, "k", blocks, self.m.constants, kept)
        moved.q = self._given_directions(by, "q", blocks, self.m.nu, kept)
        moved.u = self._given_directions(by, "u", blocks, self.m.nu, kept)
        moved.t = self._given_directions(by, "t", blocks, 1, kept)
        moved.inputs = self._given_directions(by, "inputs", blocks, self.m.inputs, kept)
        moved.u_dot = self._given_directions(by, "u_dot", blocks, self.m.nu, kept)
        moved.multipliers = self._given_directions(by, "multipliers", blocks, self.m.rows, kept)
        moved.P = self._given_directions(by, "P", blocks, contacts, kept)
        moved.f = moved.y = moved.cs = NULL
        return moved

    def tangents(self, str name, const real[:, ::1] q, const real[:, ::1] u, t, const real[:, ::1] u_dot,
                 const real[:, ::1] multipliers, const real[:, ::1] P, dict by, int blocks, columns=None):
        """Tangents (b, blocks, outputs, lanes) of the function ``name`` at states, along directions ``by`` that are the same
        for all; or those of the ``columns``, lanes of all blocks by number, (b, outputs, columns). None where it does not
        move."""
        cdef const ccgen_named_tangent *function = find_tangent(self.m, name.encode())
        cdef list kept = []
        cdef ccgen_arguments at, moved
        cdef real[:, :, :, ::1] out
        cdef real[:, :, ::1] chosen
        cdef Py_ssize_t[::1] which
        cdef Py_ssize_t i, b = q.shape[0]
        cdef _Times times = _Times(t, b)
        cdef real now
        cdef bint turns = name in REACTIONS
        if function is NULL:
            return None
        moved = self._whole(by, blocks, P.shape[1], kept)
        found = empty((b if columns is None else min(b, 1), blocks, function.outputs, self.m.derivatives.lanes))
        out = found
        if columns is not None:
            which = places_of(columns, function.outputs, self.m.derivatives.lanes)
            taken = empty((b, function.outputs, which.shape[0]))
            chosen = taken
        at.k = &self.k[0]
        at.f = at.y = at.cs = NULL
        for i in range(b if blocks and function.outputs else 0):
            now = times.at(i)
            at.q, at.u, at.t = &q[i, 0], &u[i, 0], &now
            at.inputs = self._given(now, &q[i, 0], &u[i, 0])
            at.u_dot, at.P, at.multipliers = &u_dot[i, 0], &P[i, 0], &multipliers[i, 0]
            function.function(&at, &moved, blocks, &out[i if columns is None else 0, 0, 0, 0])
            if turns:
                turn_to_second_links(self.m, blocks, self.m.derivatives.lanes, &out[i if columns is None else 0, 0, 0, 0])
            if columns is not None and which.shape[0]:
                take_columns(&out[0, 0, 0, 0], function.outputs, self.m.derivatives.lanes, which.shape[0], &which[0], 1, 0,
                             &chosen[i, 0, 0])
        return found if columns is None else taken

    def jacobians(self, q, u, t, held, dict by, dict whole, dict still, int blocks, const Py_ssize_t[::1] columns,
                  Py_ssize_t side=1):
        """Accelerations (b, n) and their derivatives (b / side, n, columns, side), of as many states ``side`` by side, with
        contacts ``held``, at states of as many times, along directions: those of ``acceleration_tangents``, all as ``whole``
        blocks, and these but for u. Behind them by state the outcome where there are none, and whether all are sure: those
        of states whose rows may depend on each other are not."""
        cdef const real[:, ::1] places = q, rates = u, of_rates, multipliers, pushes
        cdef const real[::1] times = t
        cdef Py_ssize_t i, b = places.shape[0], n = self.m.nu, lanes = self.m.derivatives.lanes
        cdef list kept = []
        cdef directions along = self._along(by, blocks, kept)
        cdef whole_directions every
        cdef _Chosen these = _Chosen(held)
        cdef int outcome = 0, sure = 1
        found, without = empty((b // side, n, columns.shape[0], side)), {}
        if held:
            u_dot, lambdas, forces, _, _, _, trouble = self.motion(q, u, t, held)
            without = {trouble[0]: trouble[1]} if trouble else {}
            pushes = forces
        else:
            u_dot, lambdas, without = self.acceleration(q, u, t)
        if without:
            return u_dot, found, without, True
        of_rates, multipliers = u_dot, np.ascontiguousarray(lambdas)
        every.along = &along
        every.all = self._whole(whole, blocks, max(self.m.contacts, 1), kept)
        every.still = self._whole(still, blocks, max(self.m.contacts, 1), kept)
        cdef _Memory memory = _Memory()
        cdef system s = self._system(memory)
        cdef Py_ssize_t apart = blocks * (n + self.m.rows) * lanes
        cdef real[::1] tangents = empty(side * apart)
        cdef real[:, :, :, ::1] out = found
        cdef Py_ssize_t[::1] chosen = places_of(columns, n + self.m.rows, lanes)
        cdef pushed at
        for i in range(b if columns.shape[0] else 0):
            at.t, at.q, at.u, at.u_dot = times[i], &places[i, 0], &rates[i, 0], &of_rates[i, 0]
            at.multipliers = &multipliers[i, 0] if self.m.rows else NULL
            at.push = &pushes[i, 0] if held else NULL
            outcome = held_tangents(&s, &at, these.given, &every, &tangents[i % side * apart], &sure)
            if outcome:
                return u_dot, found, {i: OUTCOMES[outcome]}, True
            if not sure:
                break
            if i % side == side - 1:
                take_columns(&tangents[0], n, lanes, columns.shape[0], &chosen[0], side, apart, &out[i // side, 0, 0, 0])
        return u_dot, found, {}, bool(sure)

    def collocated(self, steps, ends, held, const real[::1] c, const real[:, ::1] A, const real[:, ::1] twice, int many,
                   real small, real stays):
        """Accelerations (k, stages, n) at the nodes of ``steps`` t, h (k,), q, u, q1, u1 (k, n), with those at both ``ends``
        (k, n) of each, with contacts ``held``, and which steps (k,) have them: those whose sweeps contract. The time and the outcome where a state has none.
        See collocate_motion."""
        cdef const real[::1] t, h
        cdef const real[:, ::1] q, u, q1, u1, at_start, at_end
        t, h, q, u, q1, u1 = steps
        at_start, at_end = ends
        cdef Py_ssize_t i, k = t.shape[0]
        cdef tableau g
        cdef sweeping end
        cdef stride step
        cdef int outcome
        cdef real when = 0.0
        g.stages, g.c, g.A, g.twice = c.shape[0], &c[0], &A[0, 0], &twice[0, 0]
        end.many, end.small, end.stays = many, small, stays
        cdef _Chosen these = _Chosen(held)
        cdef _Memory memory = _Memory()
        cdef system s = self._system(memory)
        cdef real[:, :, ::1] W = empty((k, g.stages, self.m.nu))
        cdef int[::1] met = np.zeros(k + 1, dtype=np.int32)
        for i in range(k):
            step.t, step.h, step.q, step.u, step.q1, step.u1 = t[i], h[i], &q[i, 0], &u[i, 0], &q1[i, 0], &u1[i, 0]
            step.at_start, step.at_end = &at_start[i, 0], &at_end[i, 0]
            outcome = collocate_motion(&s, these.given, &g, end, &step, &W[i, 0, 0], &met[i], &when)
            if outcome:
                return np.asarray(W), np.asarray(met)[:k] != 0, (when, OUTCOMES[outcome])
        return np.asarray(W), np.asarray(met)[:k] != 0, None

    def responses(self, const real[:, ::1] q):
        """Jumps and impulses (b, n + rows, n + rows) by unit generalized impulses and by unit closure rates, driven joints
        held, and outcomes by state where there are none."""
        cdef Py_ssize_t i, j, b = q.shape[0], lanes = self.m.derivatives.lanes, n = self.m.nu
        cdef Py_ssize_t every = n + self.m.rows, blocks = -(-every // lanes)
        cdef real[:, :, ::1] units = zeros((blocks, every, lanes))
        cdef real[:, :, :, ::1] out
        cdef _Memory memory = _Memory()
        cdef system s = self._system(memory)
        cdef int outcome
        for j in range(every):
            units[j // lanes, j, j % lanes] = 1.0
        found = empty((b, blocks, every, lanes))
        out = found
        without = {}
        for i in range(b):
            outcome = impulse_tangents(&s, &q[i, 0], blocks, &units[0, 0, 0], &out[i, 0, 0, 0])
            if outcome:
                without[i] = OUTCOMES[outcome]
        return found.transpose(0, 2, 1, 3).reshape(b, every, blocks * lanes)[:, :, :every], without

    def collocate(self, const real[::1] h, const real[::1] c, const real[:, ::1] A, const real[:, ::1] twice,
                  real[:, :, :, ::1] J):
        """Matrices (k, stages n, stages n) of the collocated tangents of k steps, transposed; and J (k, stages, n, columns),
        whose first 2 n columns are by q and u at the nodes, becomes what is by those at the start. See collocate_tangents."""
        cdef Py_ssize_t i, k = J.shape[0], size = J.shape[1] * J.shape[2]
        found = empty((k, size, size))
        cdef real[:, :, ::1] out = found
        for i in range(k if size else 0):
            collocate_tangents(J.shape[2], J.shape[1], J.shape[3], h[i], &A[0, 0], &twice[0, 0], &J[i, 0, 0, 0],
                               &out[i, 0, 0])
            tangents_at_start(J.shape[2], J.shape[1], J.shape[3], h[i], &c[0], &J[i, 0, 0, 0])
        return found

    def repeat_jacobian(self, const real[::1] q, const real[::1] u, real t, dict by, int blocks, long calls):
        """Evaluate accelerations and their tangents at one state ``calls`` times, without the GIL: for timing."""
        cdef long i
        cdef int outcome
        cdef list kept = []
        cdef directions moved = self._along(by, blocks, kept)
        cdef _Memory memory = _Memory()
        cdef system s = self._system(memory)
        cdef real[::1] u_dot = empty(self.m.nu), rows = empty(self.m.rows + 1)
        cdef real[::1] out = empty(blocks * (self.m.nu + self.m.rows) * self.m.derivatives.lanes)
        cdef real miss
        with nogil:
            for i in range(calls):
                outcome = system_acceleration(&s, t, &q[0], &u[0], &u_dot[0], &rows[0])
                outcome = acceleration_tangents(&s, t, &q[0], &u[0], &u_dot[0], &rows[0], &moved, &out[0], &miss)


@cython.final
cdef class Carried:
    """Steps of lengths h (k,) that take small differences on by sweeps (motion/carried.h), over the tableau c, b, twice_b, A, twice.

    J (k, n, width, stages) are derivatives of the accelerations at their nodes; ``back`` says what puts the ends of steps back:
    of each the first entry of the state, pull (k, n, rows) and moves (k, rows, width); twice at most."""

    cdef const real[::1] h, c, b, twice_b
    cdef const real[:, ::1] A, twice
    cdef const real[:, :, :, ::1] J
    cdef const real[:, :, ::1] pull_0, pull_1, moves_0, moves_1
    cdef collocation g
    cdef carrying step

    def __init__(self, h, tableau, J, back):
        self.h, self.J = h, J
        self.c, self.b, self.twice_b, self.A, self.twice = tableau
        if self.c.shape[0] != NODES:
            raise ValueError(f"found {self.c.shape[0]} nodes, expected {NODES}")
        self.g.c, self.g.b, self.g.twice_b = &self.c[0], &self.b[0], &self.twice_b[0]
        self.g.A, self.g.twice = &self.A[0, 0], &self.twice[0, 0]
        self.step.n, self.step.width, self.step.count = self.J.shape[1], self.J.shape[2], 0
        for first, pull, moves in back:
            if not pull.shape[2]:
                continue
            if self.step.count:
                self.pull_1, self.moves_1 = np.ascontiguousarray(pull), np.ascontiguousarray(moves)
            else:
                self.pull_0, self.moves_0 = np.ascontiguousarray(pull), np.ascontiguousarray(moves)
            self.step.first[self.step.count], self.step.rows[self.step.count] = first, pull.shape[2]
            self.step.count += 1

    def through(self, Py_ssize_t number, const real[:, ::1] whole, Py_ssize_t count=1, const Py_ssize_t[::1] before=None,
                const real[:, :, ::1] jumps=None, real[:, :, ::1] seen=None):
        """What differences ``whole`` (width, columns) of the state and the arguments before a step are of the state behind
        ``count`` steps from it on, (2 n, columns); None where sweeps do not contract.

        Some are taken through ``jumps`` (m, 2 n, width), matrices, ``before`` steps (m,), which are counted from the first
        and grow; ``seen`` (m, width, columns) is filled with what they are before each of these."""
        cdef Py_ssize_t i, j = 0, columns = whole.shape[1], states = 2 * self.J.shape[1]
        cdef real[:, ::1] some = np.array(whole)
        cdef real[::1] room = empty(carry_room(&self.step, columns))
        for i in range(number, number + count if columns else number):
            if before is not None and j < before.shape[0] and before[j] == i - number:
                seen[j] = some
                jump(jumps[j], seen[j], some)
                j += 1
            self.step.h, self.step.J = self.h[i], &self.J[i, 0, 0, 0]
            if self.step.count > 0:
                self.step.pull[0], self.step.moves[0] = &self.pull_0[i, 0, 0], &self.moves_0[i, 0, 0]
            if self.step.count > 1:
                self.step.pull[1], self.step.moves[1] = &self.pull_1[i, 0, 0], &self.moves_1[i, 0, 0]
            if not carry(&self.g, &self.step, columns, &some[0, 0], &room[0]):
                return None
        return np.asarray(some)[:states]


cdef void jump(const real[:, ::1] matrix, const real[:, ::1] before, real[:, ::1] behind) noexcept nogil:
    """The first rows of differences behind a ``matrix``, as many as it has."""
    cdef Py_ssize_t i, j, k
    for i in range(matrix.shape[0]):
        for k in range(before.shape[1]):
            behind[i, k] = 0.0
        for j in range(matrix.shape[1]):
            for k in range(before.shape[1]):
                behind[i, k] += matrix[i, j] * before[j, k]
