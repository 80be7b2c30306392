# Many runs of one model, worked on by any number of threads.

cdef extern from *:
    struct numbers:
        const real *of
        size_t every
    struct rounding_sample:
        size_t count
        const real *q
        const real *u
        const unsigned char *lengths
        real limit
    ctypedef int (*run_reduction)(void *context, const real *t, const real *rows, size_t count, size_t width,
                                  real *out) noexcept nogil
    struct ensemble:
        const ccgen_model *model
        const ccgen_settings *settings
        real until
        size_t count
        numbers q, u, parameters, scales, inputs
        const input_table *table
        int projections
        real deepest
        rounding_sample sample
        size_t times
        const real *at
        size_t impact_times
        run_reduction reduce
        void *context
        size_t reduced
        int *outcome
        int *contact
        real *end
        long *steps
        long *impacts
        real *impact_t
        real *state
        real *pose
        real *velocity
        real *point
        real *gap
        real *gap_rate
        real *energy
        real *u_dot
        real *multipliers "lambda"
        real *push
        real *reaction
        real *told
        real *reduction
    int work_on(ensemble *e) nogil
    void begin_ensemble(ensemble *e) nogil
    void end_ensemble(ensemble *e) nogil
    size_t done_of(ensemble *e) nogil

ROW_NOT_BEGUN, ROW_REFUSED = -1, -2
"""How a run of an ensemble ended beside outcomes."""


cdef class Ensemble:
    """Runs of a model that differ in numbers, and what they leave: arrays with a row for each run, by name in ``answers``.

    ``work`` is called by any number of threads, each of which takes one run after another; ``end`` has them stop where they
    are; ``done`` tells how many have been made."""

    cdef ensemble e
    cdef ccgen_settings settings
    cdef input_table table
    cdef Kernels kernels
    cdef list kept
    cdef readonly dict answers

    def __cinit__(self):
        memset(&self.e, 0, sizeof(self.e))

    def __init__(self, Kernels kernels, Py_ssize_t count, q, u, *, method, real until, real rtol, real atol,
                 real fixed_step, long step_budget, long rate_budget, str kept, str on_gain, stops=(), parameters=None,
                 scales=None, inputs=None, table=None, int projections=0, real deepest=0.0, sample=None, at=None,
                 Py_ssize_t times=0, Py_ssize_t impact_times=0, bint places=False, bint forces=False, reduction=None,
                 refused=None):
        """``q``, ``u`` (count or 1, n); ``parameters`` (count, p) with ``scales`` (count, 2), a length and a time of each;
        ``inputs`` (count or 1, inputs), or a ``table`` of them, (t, values). ``sample`` (q, u, lengths, limit): where rounding
        is measured. ``at``: times of the states that are wanted, or ``times`` 1 without for that at the end; with them
        ``places`` and ``forces``. ``reduction``: address of a function, of what it is given, and how many numbers it leaves.
        ``refused`` (count,): runs that are not to be made."""
        cdef const ccgen_model *m = kernels.m
        cdef ensemble *e = &self.e
        cdef size_t n = m.nu, wanted
        self.kernels, self.kept, self.answers = kernels, [], {}
        self.settings = kernels._settings()
        self._keep_method(method)
        self.settings.rtol, self.settings.atol, self.settings.fixed_step = rtol, atol, fixed_step
        self.settings.drift, self.settings.on_gain = <int>DRIFTS.index(kept), <int>GAINS.index(on_gain)
        self.settings.step_budget, self.settings.rate_budget = step_budget, rate_budget
        if len(stops):
            self.settings.stops, self.settings.stop_count = self._numbers_of(stops), len(stops)
        e.model, e.settings, e.until, e.count = m, &self.settings, until, count
        e.q = self._rows(q, count, n)
        e.u = self._rows(u, count, n)
        if parameters is not None:
            e.parameters = self._rows(parameters, count, m.parameters)
            e.scales = self._rows(scales, count, 2)
            e.sample.count = len(sample[0])
            e.sample.q, e.sample.u = self._numbers_of(sample[0]), self._numbers_of(sample[1])
            e.sample.lengths, e.sample.limit = self._flags_of(sample[2]), sample[3]
        if inputs is not None:
            e.inputs = self._rows(inputs, count, own_inputs(m))
        if table is not None:
            self.table.count, self.table.width = len(table[0]), own_inputs(m)
            self.table.t, self.table.values = self._numbers_of(table[0]), self._numbers_of(table[1])
            e.table = &self.table
        e.projections, e.deepest = projections, deepest
        e.times = times
        if at is not None:
            e.times, e.at = len(at), self._numbers_of(at)
        e.impact_times = impact_times
        wanted = e.times
        e.outcome, e.contact = self._integers("outcome", count, ROW_NOT_BEGUN, refused), self._integers("contact", count, -1)
        e.steps, e.impacts = self._counts("steps", count), self._counts("impacts", count)
        e.end = self._reals("end", count, 2 * n + 1)
        e.impact_t = self._reals("impact_t", count, impact_times)
        e.state = self._reals("state", count * wanted, 2 * n)
        if places:
            e.pose, e.velocity = self._reals("pose", count * wanted, 3 * m.links), self._reals("velocity", count * wanted, 3 * m.links)
            e.point, e.energy = self._reals("point", count * wanted, 2 * m.points), self._reals("energy", count * wanted, 2)
            e.gap, e.gap_rate = self._reals("gap", count * wanted, m.contacts), self._reals("gap_rate", count * wanted, m.contacts)
        if forces:
            e.u_dot, e.multipliers = self._reals("u_dot", count * wanted, n), self._reals("multipliers", count * wanted, m.rows + 1)
            e.push, e.reaction = self._reals("push", count * wanted, 2 * m.contacts), self._reals("reaction", count * wanted, 3 * m.joints)
            e.told = self._reals("told", count * wanted, m.told)
        if reduction is not None:
            e.reduce, e.context, e.reduced = <run_reduction><size_t>reduction[0], <void *><size_t>reduction[1], reduction[2]
            e.reduction = self._reals("reduction", count, reduction[2])
        begin_ensemble(e)

    cdef _keep_method(self, str method):
        cdef bytes name = method.encode()
        self.kept.append(name)
        self.settings.method = name

    cdef const real *_numbers_of(self, values):
        """The address of an array of numbers that is kept."""
        cdef real[::1] flat = np.array([*np.ravel(np.asarray(values, dtype=REAL)), 0.0], dtype=REAL)
        self.kept.append(flat)
        return &flat[0]

    cdef const unsigned char *_flags_of(self, values):
        cdef unsigned char[::1] flat = np.array([*values, 0], dtype=np.uint8)
        self.kept.append(flat)
        return &flat[0]

    cdef numbers _rows(self, values, size_t count, size_t width) except *:
        """Rows of every run, or the one that all have; they are kept."""
        cdef numbers found
        cdef const real[:, ::1] rows = np.ascontiguousarray(values, dtype=REAL)
        if <size_t>rows.shape[1] != width or (<size_t>rows.shape[0] != count and rows.shape[0] != 1):
            raise ValueError(f"found rows of shape {np.shape(values)}, expected {(count, width)} or {(1, width)}")
        self.kept.append(rows)
        found.of = &rows[0, 0] if width else NULL
        found.every = width if rows.shape[0] > 1 else 0
        return found

    cdef real *_reals(self, str name, size_t count, size_t width):
        """An answer, (count, width), not numbers at first."""
        cdef real[:, ::1] out
        found = np.full((count, width), np.nan, dtype=REAL)
        self.answers[name] = found
        if not count or not width:
            return NULL
        out = found
        return &out[0, 0]

    cdef int *_integers(self, str name, size_t count, int value, refused=None) except *:
        cdef int[::1] out
        found = np.full(count + 1, value, dtype=np.intc)
        if refused is not None:
            found[:count][refused] = ROW_REFUSED
        self.answers[name] = found[:count]
        self.kept.append(found)
        out = found
        return &out[0]

    cdef long *_counts(self, str name, size_t count) except *:
        cdef long[::1] out
        found = np.zeros(count + 1, dtype=np.int_)
        self.answers[name] = found[:count]
        self.kept.append(found)
        out = found
        return &out[0]

    def work(self):
        """Make one run after another until none is left. Without the GIL."""
        cdef int outcome
        with nogil:
            outcome = work_on(&self.e)
        if outcome:
            raise MemoryError

    def end(self):
        """Have all runs end where they are."""
        end_ensemble(&self.e)

    @property
    def done(self):
        """How many have been made."""
        return done_of(&self.e)
