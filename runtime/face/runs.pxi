# Steps and whole runs.

OTHER_STATE = "a state of another model, method or precision, or written on another kind of processor"

cdef class _Stretch:
    """What a look between rows of a run needs, and the memory of all of it."""
    cdef stretch w
    cdef look l
    cdef system s
    cdef _Memory memory
    cdef _Ticker ticker
    cdef interruption asked
    cdef Supply supply
    cdef real[::1] unit, inputs, numbers, latched
    cdef const real[:, ::1] q, u
    cdef int[::1] set
    cdef signed char[::1] mode
    cdef real[:, ::1] room

    cdef tuple found(self, int outcome, Py_ssize_t n):
        """The state that was found, and how that went; raises what a controller has raised, or Ctrl-C."""
        if self.ticker.error is not None:
            raise self.ticker.error
        if self.supply is not None and self.supply.error is not None:
            raise self.supply.error
        y = np.array(self.room[0])
        return y[:n], y[n : 2 * n], OUTCOMES[outcome]

cdef class Kernels(Differentiating):
    """A model's kernels, and its runs."""

    cdef _Stretch _stretch(self, str name, t, const real[:, ::1] q, const real[:, ::1] u, Supply supply, str kept, held, rtol, atol,
                           scales, latched):
        """How a run went on from rows at the times t (n,), q and u (n, nu), n being 1 or 2."""
        if len(latched) != self.m.latches:
            raise ValueError(f"found {len(latched)} values that effects hold, expected {self.m.latches}")
        cdef _Stretch made = _Stretch()
        cdef Py_ssize_t row
        made.memory = _Memory()
        made.s = self._system(made.memory)
        made.ticker = _Ticker(None)
        memset(&made.asked, 0, sizeof(made.asked))
        made.asked.tick, made.asked.context = _tick, <void *>made.ticker
        made.s.interruption = &made.asked
        made.unit = empty(2 * self.m.nu + 1)  # other calls have other scales
        made.s.unit = &made.unit[0]
        if scales is not None:
            made.s.time, made.s.energy = scales
        set_units(&made.s)
        made.inputs = np.array(self.inputs)
        made.s.inputs = &made.inputs[0]
        made.supply = supply
        if supply is not None:
            supply.attach(&made.s)
        made.numbers = np.array([rtol, atol, *t], dtype=REAL)
        made.q, made.u = q, u
        made.set = np.array([*(contact for contact, _ in held), 0], dtype=np.int32)
        made.mode = np.array([*(MODE_NUMBERS[how] for _, how in held), 0], dtype=np.int8)
        made.latched = np.array([*latched, 0.0], dtype=REAL)
        made.room = empty((3, made.s.size))
        made.l.y, made.l.other, made.l.curve = &made.room[0, 0], &made.room[1, 0], &made.room[2, 0]
        memset(&made.w, 0, sizeof(made.w))
        made.w.system = &made.s
        made.w.method = find_method(name.encode())
        made.w.tolerance.rtol, made.w.tolerance.atol = made.numbers[0], made.numbers[1]
        made.w.drift = <drift><int>DRIFTS.index(kept)
        for row in range(q.shape[0]):
            made.w.t[row], made.w.q[row], made.w.u[row] = made.numbers[2 + row], &made.q[row, 0], &made.u[row, 0]
        made.w.count = <int>len(held)
        made.w.set, made.w.mode, made.w.latched = &made.set[0], &made.mode[0], &made.latched[0]
        return made

    def advance(self, str name, t, const real[::1] q, const real[::1] u, h, Supply supply=None, str kept="projected",
                held=(), rtol=0.0, atol=0.0, scales=None, latched=()):
        """From t on by ``h`` (s) with the method ``name``, or where that has no step with collocation, contacts ``held`` closed:
        (q, u, outcome). In one step, or without contacts and with tolerances by as many as these ask for. ``scales``:
        characteristic time (s) and energy (J). ``latched``: what effects hold."""
        cdef _Stretch one = self._stretch(name, [t], np.asarray(q)[None, :], np.asarray(u)[None, :], supply, kept, held, rtol, atol, scales, latched)
        cdef real[::1] by = np.array([h], dtype=REAL)
        start_asking(&one.asked, by[0])
        return one.found(step_from(&one.w, 0, by[0], one.l.y), self.m.nu)

    def between(self, str name, t, const real[:, ::1] q, const real[:, ::1] u, at, line, Supply supply=None, str kept="projected",
                held=(), rtol=0.0, atol=0.0, scales=None, latched=()):
        """The state at the time ``at`` between two rows of a run, which are at t (2,), q and u (2, nu): (q, u, outcome). On the
        ``line`` between both where that is so, as by time stepping, else by steps of the method from one or the other."""
        cdef _Stretch two = self._stretch(name, t, q, u, supply, kept, held, rtol, atol, scales, latched)
        cdef real[::1] when = np.array([at], dtype=REAL)
        two.w.line = bool(line)
        start_asking(&two.asked, when[0])
        return two.found(state_between(&two.w, &two.l, when[0]), self.m.nu)

    def indicators(self, const real[::1] t, const real[:, ::1] q, const real[:, ::1] u):
        """Event indicators at times t (b,) and states q and u (b, nu): values, rates and sizes, (b, indicators) each."""
        cdef Py_ssize_t i
        cdef real[::1] scales = np.array([self.length, self.time or self.duration], dtype=REAL)
        found = [empty((t.shape[0], self.m.indicators)) for _ in range(3)]
        cdef real[:, ::1] value = found[0], rate = found[1], size = found[2]
        for i in range(t.shape[0] if self.m.indicators else 0):
            self.m.indicate(&self.k[0], &q[i, 0], &u[i, 0], t[i], &scales[0], &value[i, 0], &rate[i, 0], &size[i, 0])
        return tuple(found)

    def event_values(self, real t, const real[::1] q, const real[::1] u):
        """What events set parameters to at one state: (event_values,)."""
        cdef real[::1] value = zeros(self.m.event_values + 1)
        if self.m.event_values:
            self.m.find_event_values(&self.k[0], &q[0], &u[0], t, &value[0])
        return np.asarray(value)[: self.m.event_values]

    def take_hold(self, const real[::1] q, const real[::1] u):
        """The plastic impact by which all rows of the closure that are on come to have no rates: u (n,) behind it, and the outcome."""
        cdef _Memory memory = _Memory()
        cdef system s = self._system(memory)
        cdef real[::1] after = np.array(u)
        cdef int outcome = project_velocity(&s, &q[0], &after[0])
        return np.asarray(after), OUTCOMES[outcome]

    def simulate(self, const real[::1] q, const real[::1] u, str name, real until, real rtol, real atol,
                 real fixed_step, long step_budget, long rate_budget, progress, Supply supply=None, stops=(),
                 str kept="projected", bytes state=None, str on_gain="reduce", left_at=None, events=None):
        """A whole run from t = 0, or from where the run was left that the ``state`` is of, without the GIL; a dict of what was
        recorded. Steps end at ``stops``, times that grow. ``left_at`` is called with the time, q and u that the ``state`` is of, and may raise. ``events``, of a scene that has some:
        (indicators,) whether each is ``answered`` by a function (number, direction, t, q, u, parameters), and that, or None. It answers a word of ANSWERS and values of all parameters, or None."""
        cdef size_t n = self.m.nu, stop_count = len(stops)
        cdef real[::1] ends
        cdef const real *from_q = NULL
        cdef const real *from_u = NULL
        cdef const char *left = NULL
        cdef unsigned char[::1] answered
        cdef int outcome, ended = 0
        cdef bytes method = name.encode()
        cdef _Program program = None
        if state is None and (<size_t>q.shape[0] != n or <size_t>u.shape[0] != n):
            raise ValueError(f"found {q.shape[0]} coordinates and {u.shape[0]} velocities, expected {n} of both")
        cdef ccgen_settings asked = self._settings()
        cdef _Ticker ticker = _Ticker(progress)
        asked.method, asked.rtol, asked.atol, asked.fixed_step = method, rtol, atol, fixed_step
        asked.drift, asked.on_gain = <int>DRIFTS.index(kept), <int>GAINS.index(on_gain)
        asked.step_budget, asked.rate_budget = step_budget, rate_budget
        if stop_count:
            ends = np.array([*stops], dtype=REAL)
            asked.stops, asked.stop_count = &ends[0], stop_count
        asked.tick, asked.tick_context = _tick, <void *>ticker
        if events is not None:
            asked.events = CCGEN_ACT
            if events[1] is not None:
                answered = np.array(events[0], dtype=np.uint8)
                program = _Program(events[1], n, self.m.parameters)
                asked.on_event, asked.event_context, asked.answered = _on_event, <void *>program, &answered[0]
        cdef ccgen_simulation *it = NULL
        outcome = ccgen_create(self.m, &asked, &it)
        if outcome:
            raise MemoryError if OUTCOMES[outcome] == "no_memory" else RuntimeError(OUTCOMES[outcome])
        try:
            if supply is not None:
                supply.attach(&it.system)
            else:
                memcpy(it.system.inputs, &self.inputs[0], own_inputs(self.m) * sizeof(real))
            if state is None:
                from_q, from_u = &q[0], &u[0]
            elif <size_t>len(state) != ccgen_state_size(it):
                raise ValueError(OTHER_STATE)
            else:
                left = state
            with nogil:
                outcome = ccgen_set_state(it, left) if left is not NULL else ccgen_reset(it, 0.0, from_q, from_u)
            if left_at is not None and outcome == 0:
                left_at(it.run.record.t[0], _numbers(it.run.record.y, n), _numbers(it.run.record.y + n, n))
            scales = (it.system.time, it.system.energy)
            if outcome == 0:
                with nogil:
                    outcome = simulate_through_events(it, until, &ended)
            if outcome == OUTCOME_OTHER_STATE or outcome == OUTCOME_BAD_SETTINGS:  # a damaged time may be after the end
                raise ValueError(OTHER_STATE)
            if program is not None and program.error is not None and not isinstance(program.error, KeyboardInterrupt):
                raise program.error
            if ticker.error is not None and not isinstance(ticker.error, KeyboardInterrupt):
                raise ticker.error
            if supply is not None and supply.error is not None and not isinstance(supply.error, KeyboardInterrupt):
                raise supply.error
            return self._found(it, outcome) | {"scales": scales, "ended": bool(ended)}
        finally:
            ccgen_destroy(it)

    cdef dict _found(self, ccgen_simulation *it, int outcome):
        cdef run *r = &it.run
        cdef size_t n = self.m.nu, i = r.impacts.count, rows = r.record.count, size = it.system.size
        cdef size_t width = size + self.m.latches
        cdef real end
        cdef dict came = self._came(it) if it.run.watched and rows else {}
        cdef bytes state = PyBytes_FromStringAndSize(NULL, ccgen_state_size(it))
        ccgen_get_state(it, <char *>state)
        ccgen_get_motion(it, &end, NULL, NULL)
        return dict(
            t=_numbers(r.record.t, rows),
            q=_columns(r.record.y, rows, width, n), u=_columns(r.record.y + n, rows, width, n),
            work=_columns(r.record.y + 2 * n, rows, width, 1).ravel() if size > 2 * n else zeros(rows),
            latched=_columns(r.record.y + size, rows, width, self.m.latches) if self.m.latches else empty((rows, 0)),
            impact_t=_numbers(r.impacts.t, i),
            u_minus=_numbers(r.impacts.u_minus, n * i).reshape(-1, n),
            u_plus=_numbers(r.impacts.u_plus, n * i).reshape(-1, n),
            energy_loss=_numbers(r.impacts.energy_loss, i), share=_numbers(r.impacts.share, i),
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
            stepping=[
                (r.stepping.t0[j], r.stepping.t1[j], r.stepping.step[j], r.stepping.miss[j], r.stepping.first[j],
                 r.stepping.last[j])
                for j in range(r.stepping.count) if r.stepping.last[j] > r.stepping.first[j]
            ],
            jumps=[
                _numbers(r.stepping.jump + r.stepping.first[j] + 1, r.stepping.last[j] - r.stepping.first[j])
                for j in range(r.stepping.count) if r.stepping.last[j] > r.stepping.first[j]
            ],
            outcome=OUTCOMES[outcome], t_end=end, contact=r.contact, inexact=it.system.refinement_residual,
            steps=r.steps, rejected=r.rejected, choices=r.choices, chosen_at=r.chosen_at if r.choices else None, rest_speed=r.rest_speed, evaluations=it.system.evaluations, dependent=it.system.rank_deficient,
            state=state, trace=self._trace(&r.trace), **came,
        )

    cdef tuple _trace(self, const trace *kept):
        """The last of what a run did beside steps that were accepted: (n, 3) numbers and (n, 6) whole ones of each."""
        cdef size_t n = kept_traced(kept), k
        cdef traced one
        numbers, whole = empty((n, 3)), np.empty((n, 6), dtype=np.int32)
        cdef real[:, ::1] of = numbers
        cdef int[:, ::1] words = whole
        for k in range(n):
            one = traced_at(kept, k)
            of[k, 0], of[k, 1], of[k, 2] = one.t, one.h, one.error
            words[k, 0], words[k, 1], words[k, 2], words[k, 3], words[k, 4], words[k, 5] = one.kind, one.of, one.to, one.contact, one.watch, one.outcome
        return numbers, whole

    cdef dict _came(self, ccgen_simulation *it):
        """The events of the scene up to the last row, in the order of time, and what they and joints have changed, with those of an instant that could not all be done."""
        cdef const ccgen_crossing *crossing = NULL
        cdef const real *states = NULL
        cdef size_t count = 0, j, n = self.m.nu, parameters = self.m.parameters
        cdef changes *c = &it.changes
        cdef real[::1] times, instants
        cdef int outcome
        with nogil:
            outcome = ccgen_crossings(it, &count, &crossing, &states)
        if outcome == OUTCOME_INTERRUPTED:
            raise KeyboardInterrupt
        if outcome:
            raise ValueError(f"no state between the rows at and before t = {it.run.record.t[it.run.record.count - 1]} ({OUTCOMES[outcome].replace('_', ' ')})")
        times, instants = empty(count), empty(c.tried)  # with all their digits
        for j in range(count):
            times[j] = crossing[j].t
        for j in range(c.tried):
            instants[j] = c.of[j].t
        return dict(
            crossings=[(np.asarray(times)[j].item(), crossing[j].indicator, crossing[j].direction) for j in range(count)],
            crossed=_columns(states, count, 2 * n, 2 * n) if count else empty((0, 2 * n)),
            changes=[
                (np.asarray(instants)[j].item(), c.of[j].indicator, c.of[j].gate, c.of[j].energy, c.of[j].gap, c.of[j].crossing, c.origin[j].impact)
                for j in range(c.tried)
            ],
            origins=[
                (c.origin[j].at.rows, c.origin[j].at.impacts, c.origin[j].at.modes, (c.origin[j].time, c.origin[j].energy))
                for j in range(c.count)
            ],
            values=_columns(c.values, c.tried, parameters, parameters) if c.tried else empty((0, parameters)),
        )
