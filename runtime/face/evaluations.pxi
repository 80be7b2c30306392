# A model's kernels on states, one by one or in lanes.

@cython.final
cdef class _Times:
    """One time for all states of a batch, or each one's own: ``t`` a number, or (b,). ``lanes`` are taken at once."""

    cdef const real[::1] every
    cdef real[::1] alike
    cdef real one
    cdef bint same

    def __cinit__(self, t, Py_ssize_t b, Py_ssize_t lanes=1):
        cdef Py_ssize_t l
        self.same = not isinstance(t, np.ndarray) or not t.ndim
        if self.same:
            self.one = t
            self.alike = empty(lanes)
            for l in range(lanes):
                self.alike[l] = self.one
            return
        self.every = np.ascontiguousarray(t, dtype=REAL)
        if self.every.shape[0] != b:
            raise ValueError(f"found {self.every.shape[0]} times, expected {b}")

    cdef inline real at(self, Py_ssize_t i) noexcept:
        return self.one if self.same else self.every[i]

    cdef inline const real *from_(self, Py_ssize_t first) noexcept:
        """Those of the lanes that begin with a state."""
        return &self.alike[0] if self.same else &self.every[first]


@cython.final
cdef class _Memory:
    """Scratch of one call: of its thread alone."""

    cdef arena arena

    def __dealloc__(self):
        free_arena(&self.arena)


cdef class Evaluations:
    """A model's kernels with one set of parameter values (``parameters``: (p,), SI units)."""

    cdef const ccgen_model *m
    cdef object capsule
    cdef readonly dict sizes
    cdef real[::1] p, k, restitution, friction_, lever, extent, inputs, unit
    cdef unsigned char[::1] angular, lengths
    cdef real length, time, duration
    cdef const impact_law *law
    cdef int[::1] on
    cdef int on_count, refine
    cdef real usual
    cdef readonly double inexact
    """Of the last call for accelerations or an impact: the largest relative correction that did not become small."""

    def __init__(self, capsule, parameters, real length, str law="newton", angular=(),
                 real time=0.0, real duration=1.0, lengths=()):
        if not PyCapsule_IsValid(capsule, CCGEN_CAPSULE):
            raise TypeError("not the descriptor of a ccgen model")
        self.capsule = capsule
        self.m = <const ccgen_model *>PyCapsule_GetPointer(capsule, CCGEN_CAPSULE)
        if self.m.version != CCGEN_CONTRACT_VERSION:
            raise ImportError(
                f"the model was generated for contract version {self.m.version}, this runtime has "
                f"{CCGEN_CONTRACT_VERSION}; generate it again"
            )
        m = self.m
        self.sizes = dict(n=m.nu, rows=m.rows, links=m.links, joints=m.joints, points=m.points, contacts=m.contacts,
                          parameters=m.parameters, drives=m.drives, inputs=m.inputs, switches=m.switches,
                          latches=m.latches)
        self.p = np.array([*parameters, 0.0], dtype=REAL)
        if len(parameters) != m.parameters:
            raise ValueError(f"found {len(parameters)} parameter values, expected {m.parameters}")
        self.k = zeros(max(m.constants, 1))
        self.restitution = zeros(max(m.contacts, 1))
        self.inputs, self.unit = zeros(m.inputs + 1), zeros(2 * m.nu + 1)
        self.length, self.time, self.duration, self.law = length, time, duration, find_law(law.encode())
        if self.law is NULL:
            raise ValueError(f"found the law of impact {law!r}, expected one that this runtime has")
        self.friction_ = zeros(max(m.contacts, 1))
        self.lever, self.extent = zeros(max(m.contacts, 1)), zeros(max(m.contacts, 1))
        self.angular = np.zeros(m.contacts + 1, dtype=np.uint8)
        self.lengths = np.array([i < m.base or i in lengths for i in range(m.nu)] + [0], dtype=np.uint8)
        for contact in angular:
            self.angular[contact] = 1
        self.m.derive_constants(&self.p[0], &self.k[0])
        self.on = np.zeros(m.rows + 1, dtype=np.intc)
        self.on_count = find_rows_on(m, &self.p[0], &self.on[0])
        if self.m.contacts:
            self.m.restitution(&self.k[0], &self.restitution[0])
        if self.m.friction is not NULL:
            self.m.friction(&self.k[0], &self.friction_[0])

    def rounding(self, const real[:, ::1] q, const real[:, ::1] u, t=0.0):
        """How far the accelerations that the elimination gives are from right, by the size of their first correction from the
        unreduced equations, and how large they are: (b, 2)."""
        cdef _Memory memory = _Memory()
        cdef system s = self._system(memory)
        cdef Py_ssize_t i
        cdef real whole
        found = empty((q.shape[0], 2))
        for i in range(q.shape[0]):
            found[i, 0] = rounding_of_acceleration(&s, t, &q[i, 0], &u[i, 0], &whole)
            found[i, 1] = whole
        return found

    def refine_from_now(self, usual):
        """Have every acceleration and every jump refined by what the unreduced equations miss by; accelerations less than
        the ``usual`` ones count as that large."""
        self.refine, self.usual = 1, usual

    @property
    def refined(self):
        """Whether they are."""
        return bool(self.refine)

    @property
    def rows_on(self):
        """Numbers of the closure's rows that are on, in their order."""
        return np.asarray(self.on)[: self.on_count].copy()

    @property
    def address(self):
        """Address of the model's ``struct ccgen_model``, for programs that call it from C."""
        return <size_t>self.m

    @property
    def lanes(self):
        """States that the model evaluates side by side: the vector width of the machine it was compiled for."""
        return self.m.lanes

    @property
    def hash(self):
        """Hash of the scene that the code was generated from."""
        return self.m.hash.decode()

    @property
    def works(self):
        """Whether effects without a potential do work."""
        return self.m.power is not NULL

    @property
    def friction(self):
        """Coefficient of friction of every contact, (contacts,)."""
        return np.array(self.friction_)[: self.m.contacts]

    @property
    def constants(self):
        """The constants ``k`` that the kernels read."""
        return np.array(self.k)

    cdef ccgen_settings _settings(self):
        """What a simulation has to know of the model; for the rest what is usual."""
        cdef ccgen_settings settings
        memset(&settings, 0, sizeof(settings))
        settings.parameters, settings.length = &self.p[0], self.length
        settings.time, settings.duration = self.time, self.duration
        settings.lengths, settings.angular = &self.lengths[0], &self.angular[0]
        settings.law, settings.acceleration_scale = self.law.name, self.usual if self.refine else 0.0
        return settings

    cdef system _system(self, _Memory memory):
        cdef system s
        memset(&s, 0, sizeof(s))
        s.model = self.m
        s.k = &self.k[0]
        s.restitution = &self.restitution[0]
        s.friction = &self.friction_[0] if self.m.friction is not NULL else NULL
        s.law = self.law
        s.n = self.m.nu
        s.rows_on, s.on = self.on_count, &self.on[0]
        s.size = 2 * self.m.nu + (self.m.power is not NULL or self.m.friction is not NULL)
        s.inputs = &self.inputs[0]
        s.arena = &memory.arena
        s.length, s.time, s.energy = self.length, self.time or self.duration, 1.0
        s.lengths, s.unit = &self.lengths[0], &self.unit[0]
        set_units(&s)
        set_levers(&s, &self.angular[0], &self.lever[0], &self.extent[0])
        s.refine, s.acceleration_scale = self.refine, self.usual
        return s

    def heaviest(self, const real[::1] q):
        """Kinetic energy (J) of the coordinate that has the most at a speed of its unit, a radian or the length in the
        characteristic time."""
        cdef _Memory memory = _Memory()
        cdef system s = self._system(memory)
        cdef real found = heaviest(&s, &q[0])
        if found < 0.0:
            raise MemoryError
        return found

    def motions(self, const real[::1] q):
        """A basis (n - rank, n) of the motions that keep loops shut and driven joints still at q (n,), rows that count as the
        core counts them; orthonormal in units of the coordinates."""
        cdef _Memory memory = _Memory()
        cdef system s = self._system(memory)
        found = empty((self.m.nu, self.m.nu))
        cdef real[:, ::1] out = found
        cdef int rank = free_motions(&s, &q[0], &out[0, 0])
        if rank < 0:
            raise MemoryError
        return found[: self.m.nu - rank]

    def acceleration(self, const real[:, ::1] q, const real[:, ::1] u, t, bint side_by_side=True, bint forces=True):
        """Quasi-accelerations (b, n), multipliers (b, rows), of no state unless ``forces``, and the outcome of each state
        that has none, by number, at one time ``t`` or at times (b,); where there are as many states as the model has lanes,
        in lanes, unless each is to be what it is alone."""
        cdef Py_ssize_t i, block, first, b = q.shape[0], lanes = self.m.lanes
        cdef bint in_lanes = side_by_side and b >= lanes and not self.refine and self.m.acceleration_states is not NULL
        in_lanes = in_lanes and not self.m.switches  # all lanes would be on one side
        if not in_lanes:
            lanes = 1
        cdef _Times times = _Times(t, b, lanes)
        u_dot, multipliers = empty((b, self.m.nu)), empty((b if forces else 0, self.m.rows))
        cdef real[:, ::1] out = u_dot, rows = multipliers
        cdef real[::1] unwanted = empty(self.m.rows + 1)
        cdef real *row
        cdef dict without = {}
        cdef _Memory memory = _Memory()
        cdef system s = self._system(memory)
        cdef unsigned lost = 1
        for block in range(0, b, lanes):
            first = min(block, b - lanes)
            if in_lanes:
                row = &rows[first, 0] if forces else NULL
                lost = self.m.acceleration_states(&self.k[0], &q[first, 0], &u[first, 0], times.from_(first),
                                                  &self.inputs[0], &out[first, 0], row)
            for i in range(first, first + lanes if lost else first):
                if lost >> (i - first) & 1:
                    row = &rows[i, 0] if forces else &unwanted[0]
                    found = system_acceleration(&s, times.at(i), &q[i, 0], &u[i, 0], &out[i, 0], row)
                    if found:
                        without[i] = OUTCOMES[found]
        self.inexact = s.refinement_residual
        return u_dot, multipliers, without

    def repeat_acceleration(self, const real[::1] t, const real[:, ::1] q, const real[:, ::1] u, long calls):
        """Evaluate the acceleration ``calls`` times, cycling through the states, without the GIL: for timing."""
        cdef Py_ssize_t state = 0, b = q.shape[0]
        cdef long i
        cdef real[::1] out = empty(self.m.nu), rows = empty(self.m.rows + 1)
        cdef real *found = &out[0]
        cdef real *multipliers = &rows[0]
        cdef const real *k = &self.k[0]
        if not b or t.shape[0] != b or u.shape[0] != b:
            raise ValueError(f"found {t.shape[0]}, {b} and {u.shape[0]} times, q and u, expected equally many, at least 1")
        cdef const real *inputs = self._given(t[0], &q[0, 0], &u[0, 0])
        with nogil:
            for i in range(calls):
                self.m.acceleration(k, &q[state, 0], &u[state, 0], t[state], inputs, found, multipliers)
                state = state + 1 if state + 1 < b else 0

    def acceleration_lanes(self, const real[:, ::1] q, const real[:, ::1] u, const real[::1] t):
        """Quasi-accelerations (b, n) at times ``t`` (b,), as many states at a time as the model has lanes; outcomes."""
        cdef _Memory memory = _Memory()
        cdef system s = self._system(memory)
        cdef Py_ssize_t i, j, l, b = q.shape[0], n = self.m.nu, lanes = self.m.lanes
        cdef real[:, ::1] out = empty((b, n)), x = empty((3 * n + 1, lanes))
        cdef real[::1] scratch = empty(lanes_scratch(&s) + 1)
        outcomes = []
        for i in range(0, b, lanes):
            for l in range(lanes):
                x[3 * n, l] = t[min(i + l, b - 1)]
                for j in range(n):
                    x[j, l], x[n + j, l] = q[min(i + l, b - 1), j], u[min(i + l, b - 1), j]
            outcomes.append(OUTCOMES[system_acceleration_lanes(&s, <int>(b - i), &x[3 * n, 0], &x[0, 0], &x[n, 0], &x[2 * n, 0],
                                                               &scratch[0])])
            for l in range(min(lanes, b - i)):
                for j in range(n):
                    out[i + l, j] = x[2 * n + j, l]
        return np.asarray(out), outcomes

    def impulse(self, const real[:, ::1] q, const real[:, ::1] f, const real[:, ::1] y):
        """Jumps du (b, n), impulses (b, rows) for generalized impulses f (b, n), closure rates y (b, rows + 1); outcomes."""
        cdef Py_ssize_t i, b = q.shape[0]
        cdef real[:, ::1] out = empty((b, self.m.nu)), rows = empty((b, self.m.rows + 1))
        cdef _Memory memory = _Memory()
        cdef system s = self._system(memory)
        outcomes = []
        for i in range(b):
            outcomes.append(OUTCOMES[system_impulse(&s, &q[i, 0], &f[i, 0], &y[i, 0], RANK_TOLERANCE, &out[i, 0], &rows[i, 0])])
        return np.asarray(out), np.asarray(rows)[:, : self.m.rows], outcomes

    def set_inputs(self, inputs):
        """Values of the inputs for the calls that follow."""
        cdef real[::1] values = np.ascontiguousarray(inputs, dtype=REAL)
        self.inputs[: own_inputs(self.m)] = values

    cdef real *_given(self, real t, const real *q, const real *u):
        """The inputs, and the sides on which effects are at a state."""
        if self.m.switches:
            find_sides(self.m, &self.k[0], t, q, u, &self.inputs[0])
        return &self.inputs[0]

    def inverse_dynamics(self, const real[:, ::1] q, const real[:, ::1] u, real t, const real[:, ::1] u_dot):
        """Generalized forces M u_dot + h of the open chain (b, n)."""
        cdef Py_ssize_t i, b = q.shape[0]
        cdef real[:, ::1] out = empty((b, self.m.nu))
        cdef real *given
        for i in range(b):
            given = self._given(t, &q[i, 0], &u[i, 0])
            self.m.inverse_dynamics(&self.k[0], &q[i, 0], &u[i, 0], t, given, &u_dot[i, 0], &out[i, 0])
        return np.asarray(out)

    def reactions(self, const real[:, ::1] q, const real[:, ::1] u, t, const real[:, ::1] u_dot,
                  const real[:, :] multipliers):
        """Joint reactions (b, 3 joints), on the joints' second links, at one time ``t`` or at times (b,); numbers of a row of
        ``multipliers`` lie side by side."""
        cdef Py_ssize_t i, b = q.shape[0]
        cdef real[:, ::1] out = empty((b, 3 * self.m.joints + 1))
        cdef _Times times = _Times(t, b)
        cdef real *given
        for i in range(b):
            given = self._given(times.at(i), &q[i, 0], &u[i, 0])
            self.m.reactions(&self.k[0], &q[i, 0], &u[i, 0], times.at(i), given, &u_dot[i, 0], &multipliers[i, 0], &out[i, 0])
            turn_to_second_links(self.m, 1, 1, &out[i, 0])
        return np.asarray(out)[:, : 3 * self.m.joints]

    def told(self, const real[:, ::1] q, const real[:, ::1] u, t):
        """What effects tell (b, told) at one time ``t`` or at times (b,), whether or not states have accelerations."""
        cdef Py_ssize_t i, b = q.shape[0]
        cdef real[:, ::1] out = empty((b, self.m.told + 1))
        cdef _Times times = _Times(t, b)
        cdef real *given
        for i in range(b if self.m.told else 0):
            given = self._given(times.at(i), &q[i, 0], &u[i, 0])
            self.m.outputs(&self.k[0], &q[i, 0], &u[i, 0], times.at(i), given, &out[i, 0])
        return np.asarray(out)[:, : self.m.told]

    def of_q(self, str name, const real[:, ::1] q):
        """A kernel of the configuration alone: closure, closure_jacobian, poses, points or gaps, (b, size)."""
        cdef of_q kernel
        cdef Py_ssize_t i, b = q.shape[0], size
        if name == "closure":
            kernel, size = self.m.closure, self.m.rows
        elif name == "closure_jacobian":
            kernel, size = self.m.closure_jacobian, self.m.rows * self.m.nu
        elif name == "poses":
            kernel, size = self.m.poses, 3 * self.m.links
        elif name == "points":
            kernel, size = self.m.point_positions, 2 * self.m.points
        elif name == "gaps":
            kernel, size = self.m.gaps, self.m.contacts
        else:
            raise KeyError(name)
        found = empty((b, size + 1))
        cdef real[:, ::1] out = found
        if size:
            for i in range(b):
                kernel(&self.k[0], &q[i, 0], &out[i, 0])
        return found[:, :size]

    def of_state(self, str name, const real[:, ::1] q, const real[:, ::1] u):
        """A kernel of the state by its name in the contract, such as closure_rate or slip_bias: (b, size)."""
        cdef of_state kernel
        cdef Py_ssize_t i, b = q.shape[0], size
        if name == "closure_rate":
            kernel, size = self.m.closure_rate, self.m.rows
        elif name == "velocities":
            kernel, size = self.m.velocities, 3 * self.m.links
        elif name == "energy":
            kernel, size = self.m.energy, 2
        elif name == "closure_bias":
            kernel, size = self.m.closure_bias, self.m.rows
        elif name == "momentum":
            kernel, size = self.m.momentum, self.m.nu
        elif name == "gap_rates":
            kernel, size = self.m.gap_rates, self.m.contacts
        elif name == "gap_bias":
            kernel, size = self.m.gap_bias, self.m.contacts
        elif name == "slips":
            kernel, size = self.m.slips, self.m.contacts if self.m.slips is not NULL else 0
        elif name == "slip_bias":
            kernel, size = self.m.slip_bias, self.m.contacts if self.m.slip_bias is not NULL else 0
        else:
            raise KeyError(name)
        found = empty((b, size + 1))
        cdef real[:, ::1] out = found
        if size:
            for i in range(b):
                kernel(&self.k[0], &q[i, 0], &u[i, 0], &out[i, 0])
        return found[:, :size]

    def closure_misses(self, const real[:, ::1] parameters, const real[::1] q, const real[::1] u):
        """Largest miss of the closure (m), and of its rates (m/s), at one state with each of so many sets of ``parameters``
        (b, p): (b, 2)."""
        cdef Py_ssize_t i, j
        cdef real[:, ::1] found = zeros((parameters.shape[0], 2))
        cdef real[::1] k = zeros(self.m.constants + 1), miss = zeros(self.m.rows + 1), rate = zeros(self.m.rows + 1)
        with nogil:
            for i in range(parameters.shape[0]):
                self.m.derive_constants(&parameters[i, 0], &k[0])
                self.m.closure(&k[0], &q[0], &miss[0])
                self.m.closure_rate(&k[0], &q[0], &u[0], &rate[0])
                for j in range(self.m.rows):
                    found[i, 0] = _larger(found[i, 0], miss[j])
                    found[i, 1] = _larger(found[i, 1], rate[j])
        return np.asarray(found)

    def audit(self, const real[:, ::1] q, const real[:, ::1] u, const real[::1] spent, Py_ssize_t every):
        """Over states (b, n): largest gap of a cut joint (m), largest speed at which one opens (m/s), of one state in
        ``every`` the largest of both numbers of ``rounding``, at t = 0, and (b,) by how much the energy has changed since the first
        state (J) other than by what was ``spent`` (b,) on the mechanism until then."""
        cdef Py_ssize_t i, j
        cdef real first = 0.0, gap = 0.0, speed = 0.0, lost = 0.0, whole = 0.0, size
        cdef _Memory memory = _Memory()
        cdef system s = self._system(memory)
        cdef real energy[2]
        cdef real[::1] miss = empty(self.m.rows + 1), drift = empty(q.shape[0])
        for i in range(q.shape[0]):
            self.m.energy(&self.k[0], &q[i, 0], &u[i, 0], energy)
            if i == 0:
                first = energy[0] + energy[1]
            drift[i] = energy[0] + energy[1] - first - spent[i]
            if i % every == 0:
                lost = _larger(lost, rounding_of_acceleration(&s, 0.0, &q[i, 0], &u[i, 0], &size))
                whole = _larger(whole, size)
            if not self.m.rows:
                continue
            self.m.closure(&self.k[0], &q[i, 0], &miss[0])
            for j in range(self.m.rows):
                gap = _larger(gap, miss[j])
            self.m.closure_rate(&self.k[0], &q[i, 0], &u[i, 0], &miss[0])
            for j in range(self.m.rows):
                speed = _larger(speed, miss[j])
        return gap, speed, lost, whole, np.asarray(drift)

    def project(self, q, u):
        """Nearest state on the closure in the mass metric, (b, n) each, and the outcome of each state."""
        found_q, found_u = np.array(q, order="C"), np.array(u, order="C")
        cdef real[:, ::1] new_q = found_q, new_u = found_u
        cdef _Memory memory = _Memory()
        cdef system s = self._system(memory)
        cdef Py_ssize_t i
        outcomes = []
        for i in range(new_q.shape[0]):
            found = project_position(&s, &new_q[i, 0])
            if not found:
                found = project_velocity(&s, &new_q[i, 0], &new_u[i, 0])
            outcomes.append(OUTCOMES[found])
        return found_q, found_u, outcomes

    def impact(self, const real[::1] q, const real[::1] u, const int[::1] contacts, const real[::1] e):
        """One state struck at ``contacts`` with restitution ``e``: u+ (n,), impulses (2k,) of normals and then of
        friction, outcome."""
        cdef _Memory memory = _Memory()
        cdef system s = self._system(memory)
        cdef real[::1] u_plus = empty(self.m.nu), P = zeros(2 * contacts.shape[0] + 1)
        found = impact(&s, &q[0], &u[0], <int>contacts.shape[0], &contacts[0], &e[0], &u_plus[0], &P[0])
        self.inexact = s.refinement_residual
        return np.asarray(u_plus), np.asarray(P)[: 2 * contacts.shape[0]], OUTCOMES[found]


cdef real _larger(real most, real x) noexcept nogil:
    """The larger of a number and another's absolute value; once there was something that is no number, that."""
    cdef real size = -x if x < 0 else x
    return most if size <= most or most != most else size
