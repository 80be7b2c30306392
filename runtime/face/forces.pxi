# What contacts do to motions and jumps.

@cython.final
cdef class _Chosen:
    """Contacts that are held, of each its number and how; those that a run would hold where it is None. Forces that this
    leaves open are ``shared``, among those too that are carried, or are what the motion is worked out with."""

    cdef held given
    cdef int[::1] contacts
    cdef signed char[::1] mode

    def __cinit__(self, chosen, bint shared=False):
        cdef list pushing = [one for one in chosen or () if shared or one[1] != "carried"]
        self.contacts = np.array([*(one[0] for one in pushing), 0], dtype=np.int32)
        self.mode = np.array([*(MODE_NUMBERS[one[1]] for one in pushing), 0], dtype=np.int8)
        self.given.count = -1 if chosen is None else <int>len(pushing)
        self.given.set, self.given.mode, self.given.shared = &self.contacts[0], &self.mode[0], shared


cdef class Contacting(Evaluations):
    """A model's kernels, and the forces of its contacts."""

    def closed(self, const real[:, ::1] q):
        """Which contacts are closed in each configuration (b, n): (b, contacts) of truth values."""
        cdef _Memory memory = _Memory()
        cdef system s = self._system(memory)
        cdef size_t b = q.shape[0], contacts = self.m.contacts
        cdef char[::1] out = np.zeros(b * contacts + 1, dtype=np.int8)
        if b and find_closed(&s, b, &q[0, 0], &out[0]):
            raise MemoryError
        return np.asarray(out)[:b * contacts].reshape(b, contacts).astype(bool)

    def near_limits(self, const real[:, ::1] q):
        """In which configurations (b, n) rows are so near to dependence that what ``motion`` tells is a limit, if there is one, or
        of which that cannot be told: (b,) of truth values."""
        cdef _Memory memory = _Memory()
        cdef system s = self._system(memory)
        cdef size_t i, b = q.shape[0]
        cdef char[::1] out = np.zeros(b + 1, dtype=np.int8)
        for i in range(b):
            out[i] = near_a_limit(&s, &q[i, 0], 0)
        return np.asarray(out)[:b].astype(bool)

    def motion(self, const real[:, ::1] q, const real[:, ::1] u, t, chosen=None, Supply supply=None, latched=None, bint shared=False):
        """Quasi-accelerations (b, n), multipliers (b, rows), contact forces (b, 2 contacts), normal ones first, joint
        reactions (b, 3 joints) and what effects tell (b, told) at one time or at times (b,), without the GIL; in which states (b,) rows are so nearly
        dependent that none of these is known; and, where a state has none, its number, the outcome, and of what prevents it the name, the contact and the size.

        Contacts are held as ``chosen`` says, of each its number and how; those that a run would hold
        where it is None. Forces that this leaves open are ``shared``: those of least norm within Coulomb's limits, of contacts that
        are carried, or said to be at their limit, as of others; where they are not, these have the forces that this says.
        ``latched`` (b, latches) is what effects hold, None where each state stands for itself."""
        cdef size_t b = q.shape[0], n = self.m.nu, rows = self.m.rows + 1, pushes = 2 * self.m.contacts, every
        cdef size_t carried = 3 * self.m.joints
        cdef real[:, ::1] out = empty((b, n)), forces = empty((b, rows)), push = empty((b, max(pushes, 1)))
        cdef real[:, ::1] reactions = empty((b, max(carried, 1))), told = empty((b, max(self.m.told, 1)))
        cdef real[::1] times = np.ascontiguousarray(np.atleast_1d(t), dtype=REAL), inputs = np.array(self.inputs)
        cdef char[::1] unknown = np.zeros(b + 1, dtype=np.int8)
        cdef _Chosen these = _Chosen(chosen, shared)
        cdef real[:, ::1] holding
        cdef const real *holds = NULL
        if self.m.latches and latched is not None and b:
            holding = np.ascontiguousarray(latched, dtype=REAL)
            if <size_t>holding.shape[0] != b or holding.shape[1] != self.m.latches:
                raise ValueError(f"found {np.shape(latched)} values that effects hold, expected {(b, self.m.latches)}")
            holds = &holding[0, 0]
        cdef obstruction found
        cdef int outcome = 0
        cdef _Memory memory = _Memory()
        cdef system s = self._system(memory)
        every = 1 if times.shape[0] == <Py_ssize_t>b and b > 1 else 0
        s.inputs = &inputs[0]
        if supply is not None:
            supply.attach(&s)
        if b:
            with nogil:
                outcome = held_forces(&s, b, every, &times[0], &q[0, 0], &u[0, 0], holds, these.given, &out[0, 0], &forces[0, 0],
                                      &push[0, 0], &reactions[0, 0], &told[0, 0], &unknown[0], &found)
        if supply is not None and supply.error is not None:
            raise supply.error
        self.inexact = s.refinement_residual
        trouble = None
        if b and (outcome or found.why):
            trouble = (found.state, OUTCOMES[outcome], OBSTACLES[found.why], found.contact, found.size)
        return np.asarray(out), np.asarray(forces)[:, : self.m.rows], np.asarray(push)[:, :pushes], np.asarray(reactions)[:, :carried], np.asarray(told)[:, :self.m.told], np.asarray(unknown)[:b].astype(bool), trouble

    def contact_reactions(self, const real[:, ::1] q, const real[:, ::1] P):
        """What forces P (b, 2 contacts) of the contacts, normal ones first, add to the joint reactions (b, 3 joints), on the
        joints' second links."""
        cdef Py_ssize_t i, b = q.shape[0]
        cdef real[:, ::1] out = zeros((b, 3 * self.m.joints + 1))
        if self.m.contact_reactions is not NULL:
            for i in range(b):
                self.m.contact_reactions(&self.k[0], &q[i, 0], &P[i, 0], &out[i, 0])
                turn_to_second_links(self.m, 1, 1, &out[i, 0])
        return np.asarray(out)[:, : 3 * self.m.joints]

    def joint_impulses(self, const real[:, ::1] q, const real[:, ::1] du, const real[:, ::1] P):
        """Impulses of the joints (b, 3 joints), on their second links, in impacts with jumps (b, n) and impulses P (b, 2 contacts); outcomes."""
        cdef Py_ssize_t i, b = q.shape[0]
        cdef real[:, ::1] out = zeros((b, 3 * self.m.joints + 1))
        cdef _Memory memory = _Memory()
        cdef system s = self._system(memory)
        outcomes = []
        for i in range(b):
            outcomes.append(OUTCOMES[joint_impulses(&s, &q[i, 0], &du[i, 0], &P[i, 0], &out[i, 0])])
        return np.asarray(out)[:, : 3 * self.m.joints], outcomes
