# Steps and whole runs.

cdef class Kernels(Contacting):
    """A model's kernels, and its runs."""

    def advance(self, str name, t, const real[::1] q, const real[::1] u, h, Supply supply=None, str kept="projected",
                held=(), rtol=0.0, atol=0.0):
        """From t on by ``h`` (s) with the method ``name``, contacts ``held`` closed: (q, u, outcome). In one step, or
        without contacts and with tolerances by as many as these ask for."""
        cdef real[::1] times = np.array([t, h, rtol, atol], dtype=REAL)
        cdef tolerance bound
        bound.rtol, bound.atol = times[2], times[3]
        cdef system s = self._system()
        cdef real[::1] inputs = np.array(self.inputs)
        s.inputs = &inputs[0]
        if supply is not None:
            supply.attach(&s)
        cdef real[::1] y = np.concatenate([q, u, zeros(1)])
        s.baumgarte = BAUMGARTE if kept == "damped" else 0.0
        cdef int[::1] chosen = np.array([*(contact for contact, _ in held), 0], dtype=np.int32)
        cdef signed char[::1] mode = np.array([*(MODE_NUMBERS[how] for _, how in held), 0], dtype=np.int8)
        found = run_advance(&s, find_method(name.encode()), bound, <drift><int>DRIFTS.index(kept), times[0], times[1],
                            <int>len(held), &chosen[0], &mode[0], &y[0])
        if supply is not None and supply.error is not None:
            raise supply.error
        n = self.m.nu
        return np.asarray(y)[:n], np.asarray(y)[n : 2 * n], OUTCOMES[found]

    def simulate(self, const real[::1] q, const real[::1] u, str name, real until, real rtol, real atol,
                 real fixed_step, long step_budget, long second_budget, progress, Supply supply=None, stops=(),
                 str kept="projected"):
        """A whole run from t = 0 without the GIL; a dict of what was recorded. Steps end at ``stops``, times that grow."""
        cdef size_t n = self.m.nu, room = self.m.rows + 2 * self.m.contacts + 1, stop_count = len(stops), i
        cdef real[::1] inputs = np.array(self.inputs)
        cdef real[::1] y = zeros(2 * n + 1), ends = empty(stop_count + 1), scratch = zeros(3 * room + 6 * n)
        if <size_t>q.shape[0] != n or <size_t>u.shape[0] != n:
            raise ValueError(f"found {q.shape[0]} coordinates and {u.shape[0]} velocities, expected {n} of both")
        memcpy(&y[0], &q[0], n * sizeof(real))
        memcpy(&y[n], &u[0], n * sizeof(real))
        for i in range(stop_count):
            ends[i] = stops[i]
        ends[stop_count] = until
        cdef system s = self._system()
        s.inputs = &inputs[0]
        s.multipliers, s.rows, s.bias = &scratch[0], &scratch[room], &scratch[2 * room]
        s.jump, s.u_dot, s.projected = &scratch[3 * room], &scratch[3 * room + n], &scratch[3 * room + 4 * n]
        cdef run r
        cdef _Ticker ticker = _Ticker(progress)
        r.start, r.until = 0.0, until
        r.tolerance.rtol, r.tolerance.atol = rtol, atol
        r.stops, r.stop_count = &ends[0], stop_count
        r.fixed_step, r.step_budget, r.second_budget = fixed_step, step_budget, second_budget
        r.method = find_method(name.encode())
        r.drift = <drift><int>DRIFTS.index(kept)
        s.baumgarte = BAUMGARTE if kept == "damped" else 0.0
        r.interruption.tick, r.interruption.context = _tick, <void *>ticker
        r.record.count = r.impacts.count = r.impacts.contact_count = 0
        r.steps = r.rejected = 0
        _clear(&r)
        if supply is not None:
            supply.attach(&s)
        try:
            with nogil:
                run_simulation(&s, &r, &y[0])
            if ticker.error is not None and not isinstance(ticker.error, KeyboardInterrupt):
                raise ticker.error
            if supply is not None and supply.error is not None and not isinstance(supply.error, KeyboardInterrupt):
                raise supply.error
            return self._found(&r, s.size, s.evaluations, s.rank_deficient, s.refinement_residual)
        finally:
            free_run(&r)

    cdef dict _found(self, run *r, size_t size, long evaluations, long dependent, real inexact):
        cdef size_t n = self.m.nu, i = r.impacts.count, rows = r.record.count
        return dict(
            t=_numbers(r.record.t, rows),
            q=_columns(r.record.y, rows, size, n), u=_columns(r.record.y + n, rows, size, n),
            work=_columns(r.record.y + 2 * n, rows, size, 1).ravel() if size > 2 * n else zeros(rows),
            impact_t=_numbers(r.impacts.t, i),
            u_minus=_numbers(r.impacts.u_minus, n * i).reshape(-1, n),
            u_plus=_numbers(r.impacts.u_plus, n * i).reshape(-1, n),
            energy_loss=_numbers(r.impacts.energy_loss, i),
            first=[r.impacts.first[j] for j in range(i + 1)] if i else [0],
            after=[r.impacts.after[j] for j in range(i)],
            contacts=[r.impacts.contact[j] for j in range(r.impacts.contact_count)],
            impulses=_numbers(r.impacts.impulse, r.impacts.contact_count),
            friction=_numbers(r.impacts.friction, r.impacts.contact_count),
            hold_t=_numbers(r.modes.t, r.modes.count),
            held=[
                [(r.modes.contact[k], MODES[r.modes.mode[k]]) for k in range(r.modes.first[j], r.modes.first[j + 1])]
                for j in range(r.modes.count)
            ],
            shares=[
                [r.modes.weight[k] for k in range(r.modes.first[j], r.modes.first[j + 1])] for j in range(r.modes.count)
            ],
            outcome=OUTCOMES[r.outcome], t_end=r.t, contact=r.contact, inexact=inexact,
            steps=r.steps, rejected=r.rejected, evaluations=evaluations, dependent=dependent,
        )


cdef void _clear(run *r) noexcept:
    r.record.t = r.record.y = NULL
    r.impacts.t = r.impacts.u_minus = r.impacts.u_plus = r.impacts.energy_loss = r.impacts.impulse = r.impacts.friction = NULL
    r.impacts.first = r.impacts.after = NULL
    r.impacts.contact = NULL
    r.modes.t, r.modes.first, r.modes.contact, r.modes.mode, r.modes.weight = NULL, NULL, NULL, NULL, NULL
    r.modes.count = r.modes.room = r.modes.contact_count = r.modes.contact_room = 0
    r.record.room = r.impacts.room = r.impacts.contact_room = 0
