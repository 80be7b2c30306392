# What a run asks Python for: inputs, and whether it is to go on.

cdef class _Ticker:
    """What a long run does now and then: look for Ctrl-C, and tell how far it is."""

    cdef object progress
    cdef public object error

    def __init__(self, progress):
        self.progress = progress
        self.error = None


cdef int _tick(void *context, real t) noexcept with gil:
    cdef _Ticker ticker = <_Ticker>context
    try:
        PyErr_CheckSignals()
        if ticker.progress is not None:
            ticker.progress(t)
    except BaseException as error:
        ticker.error = error
        return 1
    return 0


ANSWERS = ("go_on", "end", "refuse")
"""What a function answers to an event, in the order of the core's numbers."""


cdef class _Program:
    """What is asked at events: a function, for n velocities and so many parameters."""

    cdef object function
    cdef public object error
    cdef Py_ssize_t n, parameters

    def __init__(self, function, n, parameters):
        self.function, self.error = function, None
        self.n, self.parameters = n, parameters


cdef int _on_event(void *context, const ccgen_crossing *event, const real *q, const real *u, real *parameters) noexcept with gil:
    """Ask the function; what it raises is kept, and interrupts the run."""
    cdef _Program program = <_Program>context
    cdef real[::1] values
    try:
        word, found = program.function(event.indicator, event.direction, event.t, _numbers(q, program.n), _numbers(u, program.n), _numbers(parameters, program.parameters))
        if found is not None and program.parameters:
            values = np.ascontiguousarray(found, dtype=REAL)
            memcpy(parameters, &values[0], program.parameters * sizeof(real))
        return <int>ANSWERS.index(word)
    except BaseException as error:
        program.error = error
        return -1


cdef class Supply:
    """Inputs of one run: a function of (t, q, u) that gives an array of them, or a table, values (rows, inputs) over t."""

    cdef object function
    cdef public object error
    cdef Py_ssize_t n, width
    cdef real[::1] t
    cdef real[:, ::1] values
    cdef input_table rows

    def __init__(self, function=None, t=None, values=None):
        self.function, self.error = function, None
        if function is None:
            self.t, self.values = np.array(t, dtype=REAL), np.array(values, dtype=REAL, order="C")
            if not self.t.shape[0] or self.values.shape[0] != self.t.shape[0]:
                raise ValueError("a table needs as many rows as times, and at least one")

    cdef void attach(self, system *s) except *:
        self.n, self.width, self.error = s.n, own_inputs(s.model), None
        if self.function is not None:
            s.input_source, s.context = _supply, <void *>self
            return
        if self.values.shape[1] != self.width or not self.width:
            raise ValueError(f"found {self.values.shape[1]} inputs, expected {self.width}")
        self.rows.count, self.rows.width, self.rows.row = self.t.shape[0], <int>self.width, 0
        self.rows.t, self.rows.values = &self.t[0], &self.values[0, 0]
        s.input_source, s.context = input_from_table, &self.rows


cdef int _supply(void *context, real t, const real *q, const real *u, real *inputs) noexcept with gil:
    """Ask the function; what it raises is kept, and it is not asked again."""
    cdef Supply supply = <Supply>context
    cdef real[::1] found
    if supply.error is not None:
        return 1
    try:
        found = np.asarray(supply.function(t, _numbers(q, supply.n), _numbers(u, supply.n)), dtype=REAL)
        if found.shape[0] != supply.width:
            raise ValueError(f"found {found.shape[0]} inputs, expected {supply.width}")
        memcpy(inputs, &found[0], supply.width * sizeof(real))
    except BaseException as error:
        supply.error = error
        return 1
    return 0
