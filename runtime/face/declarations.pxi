# What the compiled core declares, and names for its enumerations.

cdef extern from "core/interface/face.h":
    ctypedef double real "ccgen_real"  # whatever the compiled core computes with
    const char *CCGEN_CAPSULE

ctypedef void (*of_q)(const real *k, const real *q, real *out) noexcept nogil
ctypedef void (*of_state)(const real *k, const real *q, const real *u, real *out) noexcept nogil

cdef extern from *:
    int CCGEN_CONTRACT_VERSION
    struct ccgen_arguments:
        const real *k
        const real *q
        const real *u
        const real *t
        const real *inputs
        const real *u_dot
        const real *multipliers
        const real *P
        const real *f
        const real *y
        const real *cs
    struct ccgen_named_tangent:
        const char *name
        int outputs
        int (*function)(const ccgen_arguments *at, const ccgen_arguments *by, int blocks, real *tangents) noexcept nogil
    struct ccgen_derivatives:
        int lanes, count
        const ccgen_named_tangent *tangents
    struct ccgen_model:
        int version
        const char *name
        const char *hash
        int nq, nu, base, rows, links, joints, points, contacts, parameters, constants, inputs, drives, switches, latches, told, indicators, event_values, lanes
        void (*derive_constants)(const real *p, real *k) noexcept nogil
        int (*acceleration)(const real *k, const real *q, const real *u, real t, const real *inputs,
                            real *u_dot, real *lambda_) noexcept nogil
        unsigned (*acceleration_lanes)(const real *k, const real *q, const real *u, const real *t,
                                       const real *inputs, real *u_dot, real *lambda_) noexcept nogil
        unsigned (*acceleration_states)(const real *k, const real *q, const real *u, const real *t,
                                        const real *inputs, real *u_dot, real *lambda_) noexcept nogil
        int (*impulse)(const real *k, const real *q, const real *f, const real *y, real *du,
                       real *Lambda) noexcept nogil
        void (*reactions)(const real *k, const real *q, const real *u, real t, const real *inputs,
                          const real *u_dot, const real *lambda_, real *reaction) noexcept nogil
        of_q closure, closure_jacobian, poses, point_positions, gaps
        of_state closure_rate, closure_bias, momentum, velocities, energy, gap_rates, gap_bias
        void (*inverse_dynamics)(const real *k, const real *q, const real *u, real t, const real *inputs,
                                 const real *u_dot, real *f) noexcept nogil
        void (*power)(const real *k, const real *q, const real *u, real t, const real *inputs,
                      const real *u_dot, const real *lambda_, real *power) noexcept nogil
        void (*restitution)(const real *k, real *e) noexcept nogil
        void (*friction)(const real *k, real *mu) noexcept nogil
        of_state slips, slip_bias, contact_reactions
        void (*outputs)(const real *k, const real *q, const real *u, real t, const real *inputs,
                        real *value) noexcept nogil
        void (*indicate)(const real *k, const real *q, const real *u, real t, const real *scales, real *value, real *rate,
                         real *size) noexcept nogil
        void (*find_event_values)(const real *k, const real *q, const real *u, real t, real *value) noexcept nogil
        const ccgen_derivatives *derivatives

cdef extern from *:
    enum outcome:
        pass
    enum drift:
        pass
    enum gain:
        pass
    struct interruption:
        int (*tick)(void *context, real t) noexcept nogil
        void *context
    void start_asking(interruption *interruption, real t) nogil
    struct impact_law:
        const char *name
    const impact_law *find_law(const char *name) nogil
    struct arena:
        pass
    void free_arena(arena *memory) nogil
    struct system:
        const ccgen_model *model
        const real *k
        const real *restitution
        const real *friction
        const impact_law *law
        int n, rows_on, size
        const int *on
        real *inputs
        int (*input_source)(void *context, real t, const real *q, const real *u, real *inputs) noexcept nogil
        void *context
        interruption *interruption
        arena *arena
        real baumgarte
        void *active
        real length, time, energy
        const unsigned char *lengths
        real *unit
        const real *extent
        const real *lever
        int refine
        real acceleration_scale
        real refinement_residual
        long evaluations
        long rank_deficient
    int find_rows_on(const ccgen_model *m, const real *parameters, int *on) nogil
    void set_units(system *s) nogil
    real heaviest(system *s, const real *q) nogil
    void set_levers(system *s, const unsigned char *angular, real *lever, real *extent) nogil
    struct input_table:
        size_t count
        int width
        const real *t
        const real *values
        size_t row
    int own_inputs(const ccgen_model *m)
    void find_sides(const ccgen_model *m, const real *k, real t, const real *q, const real *u, real *inputs) noexcept nogil
    void turn_to_second_links(const ccgen_model *m, size_t blocks, size_t lanes, real *reaction) noexcept nogil
    int input_from_table(void *table, real t, const real *q, const real *u, real *inputs) noexcept nogil
    int system_acceleration(system *s, real t, const real *q, const real *u, real *u_dot, real *lambda_) nogil
    int system_acceleration_lanes(system *s, int wanted, const real *t, const real *q, const real *u, real *u_dot,
                                  real *scratch) nogil
    size_t lanes_scratch(const system *s) nogil
    int system_impulse(system *s, const real *q, const real *f, const real *y, real nearest, real *du,
                       real *Lambda) nogil
    int free_motions(system *s, const real *q, real *motions) nogil
    const real RANK_TOLERANCE
    struct collocation:
        const real *c
        const real *b
        const real *twice_b
        const real *A
        const real *twice
    struct carrying:
        int n, width, count
        real h
        const real *J
        int first[2]
        int rows[2]
        const real *pull[2]
        const real *moves[2]
    enum:
        NODES
    int carry(const collocation *g, const carrying *step, int columns, real *whole, real *room) nogil
    size_t carry_room(const carrying *step, int columns) nogil
    int invert_sure(int n, const real *W, real sure, real *inverse, real *scratch) nogil
    bint numbers_within "all_within"(size_t n, const real *x, real limit) nogil
    bint numbers_finite "all_finite"(size_t n, const real *x) nogil
    int project_position(system *s, real *q) nogil
    int project_velocity(system *s, const real *q, real *u) nogil
    int impact(system *s, const real *q, const real *u_minus, int count, const int *chosen, const real *e,
               real *u_plus, real *P) nogil
    struct held:
        int count
        const int *set
        const signed char *mode
        int shared
    struct obstruction:
        size_t state
        int contact
        int why
        real size
    int held_forces(system *s, size_t count, size_t every, const real *t, const real *q, const real *u, const real *latched, held chosen,
                    real *u_dot, real *lambda_, real *push, real *reaction, real *told, char *unknown, obstruction *found) nogil
    int joint_impulses(system *s, const real *q, const real *du, const real *P, real *reaction) nogil
    int near_a_limit(system *s, const real *q, int rank) nogil
    int find_closed(const system *s, size_t count, const real *q, char *closed) nogil
    enum:
        MOVES
    struct directions:
        ccgen_arguments by
        int blocks
        int first[4]
        int count[4]
    const ccgen_named_tangent *find_tangent(const ccgen_model *m, const char *name) nogil
    int acceleration_tangents(system *s, real t, const real *q, const real *u, const real *u_dot, const real *lambda_,
                              const directions *along, real *tangents, real *miss) nogil
    void collocate_tangents(int n, int stages, int width, real h, const real *A, const real *twice, const real *J,
                            real *K) nogil
    void tangents_at_start(int n, int stages, int width, real h, const real *c, real *J) nogil
    int impulse_tangents(system *s, const real *q, int blocks, const real *right, real *tangents) nogil
    struct pushed:
        real t
        const real *q
        const real *u
        const real *u_dot
        const real *multipliers
        const real *push
    struct whole_directions:
        const directions *along
        ccgen_arguments all, still
    int held_tangents(system *s, const pushed *at, held chosen, const whole_directions *by, real *tangents, int *sure) nogil
    struct tableau:
        int stages
        const real *c
        const real *A
        const real *twice
    struct sweeping:
        int many
        real small, stays
    struct stride:
        real t, h
        const real *q
        const real *u
        const real *q1
        const real *u1
        const real *at_start
        const real *at_end
    int collocate_motion(system *s, held chosen, const tableau *g, sweeping end, const stride *step, real *W, int *met,
                         real *when) nogil
    real rounding_of_acceleration(system *s, real t, const real *q, const real *u, real *whole) nogil

cdef extern from *:
    struct tolerance:
        real rtol, atol
        const real *unit
    struct method:
        const char *name
        int order
    int estimates_errors(const method *m) nogil
    const method *find_method(const char *name) nogil
    const method **all_methods

cdef extern from *:
    struct record:
        size_t count, room
        real *t
        real *y
    struct impacts:
        size_t count, room, contact_count, contact_room
        real *t
        real *u_minus
        real *u_plus
        real *energy_loss
        real *share
        size_t *first
        size_t *after
        int *contact
        real *impulse
        real *friction
    struct mode_history:
        size_t count, room, contact_count, contact_room
        real *t
        size_t *first
        int *contact
        signed char *mode
    struct stepping:
        size_t count, room
        real *t0
        real *t1
        real *step
        real *miss
        size_t *first
        size_t *last
        real *jump
    struct traced:
        real t, h, error
        int kind, of, to, contact, watch, outcome
    struct trace:
        traced *of
        size_t count, highest
    size_t kept_traced(const trace *trace)
    traced traced_at(const trace *trace, size_t k)
    struct run:
        real until
        tolerance tolerance
        const real *stops
        size_t stop_count
        real fixed_step
        long step_budget, rate_budget
        const method *method
        gain on_gain
        interruption interruption
        int watched
        record record
        impacts impacts
        mode_history modes
        stepping stepping
        trace trace
        int contact
        long steps, rejected, choices
        real rest_speed, chosen_at
    struct stretch:
        const system *system
        const method *method
        tolerance tolerance
        drift drift
        real t[2]
        const real *q[2]
        const real *u[2]
        int line
        int count
        const int *set
        const signed char *mode
        const real *latched
    struct look:
        real *y
        real *other
        real *curve
    int state_between(const stretch *w, const look *l, real t) nogil
    int step_from(const stretch *w, int end, real h, real *y) nogil

cdef extern from *:
    struct ccgen_crossing:
        real t
        int indicator, direction
    struct ccgen_settings:
        const real *parameters
        real length, time, duration
        const unsigned char *lengths
        const unsigned char *angular
        const char *law
        real acceleration_scale
        const char *method
        real rtol, atol, fixed_step
        int drift
        int on_gain
        long step_budget, rate_budget
        const real *stops
        size_t stop_count
        int events
        int (*inputs)(void *context, real t, const real *q, const real *u, real *inputs) noexcept nogil
        void *context
        int (*on_event)(void *context, const ccgen_crossing *event, const real *q, const real *u, real *parameters) noexcept nogil
        void *event_context
        const unsigned char *answered
        int (*tick)(void *context, real t) noexcept nogil
        void *tick_context
    struct ccgen_change:
        real t
        int indicator, gate
        real energy, gap
        size_t crossing, row
    struct recorded:
        size_t rows, impacts, modes
    struct origin:
        recorded at
        size_t impact
        real time, energy
    struct changes:
        size_t count, tried
        ccgen_change *of
        origin *origin
        real *values
    struct ccgen_simulation:
        system system
        run run
        changes changes
    int ccgen_crossings(ccgen_simulation *made, size_t *count, const ccgen_crossing **crossings, const real **states) nogil
    enum:
        CCGEN_ACT
    int ccgen_create(const ccgen_model *model, const ccgen_settings *settings, ccgen_simulation **made) nogil
    void ccgen_get_motion(const ccgen_simulation *made, real *t, real *q, real *u) nogil
    int ccgen_reset(ccgen_simulation *made, real t, const real *q, const real *u) nogil
    int simulate_through_events(ccgen_simulation *made, real until, int *ends) nogil
    size_t ccgen_state_size(const ccgen_simulation *made) nogil
    void ccgen_get_state(const ccgen_simulation *made, void *bytes) nogil
    int ccgen_set_state(ccgen_simulation *made, const void *bytes) nogil
    void ccgen_destroy(ccgen_simulation *made) nogil
    const char *ccgen_outcome_name(int code) nogil
    const char *ccgen_mode_name(int mode) nogil
    const char *ccgen_drift_name(int drift) nogil
    const char *ccgen_gain_name(int gain) nogil
    const char *obstacle_name(int obstacle) nogil
    enum:
        OUTCOME_OTHER_STATE, OUTCOME_BAD_SETTINGS, OUTCOME_INTERRUPTED
        OUTCOME_COUNT "OUTCOMES"
        DRIFT_COUNT "DRIFTS"
        GAIN_COUNT "GAINS"
        OBSTACLE_COUNT "OBSTACLES"

cdef extern from *:
    struct tolerance_entry:
        const char *name
        real value
        int of
        const char *decides
        const char *because
    const tolerance_entry *tolerance_entries
    struct tolerance_order:
        int less, more
    const tolerance_order *tolerance_orders

Tolerance = namedtuple("Tolerance", "value of decides because layer")
"""A threshold of the core: a number, what it is times, what it decides, why it is as large, and the layer that asks for it."""

OF = ("", "length", "speed", "time", "unit", "tolerance")
"""What thresholds are times, by ``enum tolerance_of``."""


cdef tuple _tolerances():
    """All thresholds by name, and the names of those that are ordered."""
    cdef int i = 0
    found, names, orders, layer = {}, [], [], ""
    while tolerance_entries[i].name is not NULL:
        entry = tolerance_entries[i]
        name = entry.name.decode()
        names.append(name)
        if entry.decides is NULL:
            layer = name
        else:
            found[name] = Tolerance(entry.value, OF[entry.of], entry.decides.decode(), entry.because.decode(), layer)
        i += 1
    i = 0
    while tolerance_orders[i].less >= 0:
        orders.append((names[tolerance_orders[i].less], names[tolerance_orders[i].more]))
        i += 1
    return found, tuple(orders)


TOLERANCES, TOLERANCE_ORDERS = _tolerances()

OUTCOMES = tuple(ccgen_outcome_name(code).decode() for code in range(OUTCOME_COUNT))
"""Names of ``enum outcome``, in its order."""

MODES = {mode: ccgen_mode_name(mode).decode() for mode in range(-128, 128) if ccgen_mode_name(mode) is not NULL}
"""How contacts stay closed, by ``enum contact_mode``, whose numbers are of signed characters."""

MODE_NUMBERS = {name: mode for mode, name in MODES.items()}
"""``enum contact_mode`` by its names."""

OBSTACLES = tuple(obstacle_name(number).decode() for number in range(OBSTACLE_COUNT))
"""Names of ``enum obstacle``, in its order."""


REAL = np.dtype(f"f{sizeof(real)}")
"""The type of all numbers here."""

empty, zeros = partial(np.empty, dtype=REAL), partial(np.zeros, dtype=REAL)

DRIFTS = tuple(ccgen_drift_name(number).decode() for number in range(DRIFT_COUNT))
"""Names of ``enum drift``, in its order: ways to keep the closure, the default first."""

GAINS = tuple(ccgen_gain_name(number).decode() for number in range(GAIN_COUNT))
"""Names of ``enum gain``, in its order: what becomes of an impact that would gain energy, the default first."""
