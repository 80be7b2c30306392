/* Sweeps in vectors of WIDTH numbers, for processors that TARGET names, under the names that NAMED makes; carried.c includes this for each
 * length. The sums of a group of columns, or of coordinates, are in registers: `side`, how many columns are side by side, and other
 * counts of the inner loops are known to the compiler. */

#define INLINE TARGET inline __attribute__((always_inline))
#define LANES NAMED(lanes)
#define PARTS (NODES / WIDTH) /* of the numbers of all nodes */
#define GROUP (WIDTH)         /* columns, of 8 vectors together */
#define PAIR (WIDTH > 1 ? WIDTH / 2 : 1)

#if WIDTH > 1
typedef double LANES __attribute__((vector_size(WIDTH * sizeof(double)), aligned(sizeof(double)), may_alias));
#else
typedef double LANES;
#endif

/* The coordinates that act, first. Squares tell: what is so small that they vanish moves nothing. */
static INLINE void NAMED(find_acting)(struct sweeping_step *s)
{
    const size_t n = s->of->n, width = s->of->width;
    const LANES *J = (const LANES *)s->of->J;
    int acting = 0, still = 0;
    for (size_t j = 0; j < n; j++) {
        LANES part[PARTS] = {0};
        for (size_t i = 0; i < n; i++)
            for (int p = 0; p < PARTS; p++) {
                const LANES by_q = J[(i * width + j) * PARTS + p], by_u = J[(i * width + n + j) * PARTS + p];
                part[p] += by_q * by_q + by_u * by_u;
            }
        double each[NODES], sum = 0.0;
        memcpy(each, part, sizeof each);
        for (int k = 0; k < NODES; k++)
            sum += each[k];
        if (sum != 0.0) /* also what is none */
            s->order[acting++] = (int)j;
        else
            s->still[still++] = (int)j;
    }
    s->acting = acting;
    memcpy(s->order + acting, s->still, still * sizeof *s->order);
}

/* The derivatives by those that act */
static INLINE void NAMED(take_derivatives)(struct sweeping_step *s)
{
    const int n = s->of->n, m = s->acting, width = s->of->width;
    const LANES *J = (const LANES *)s->of->J;
    LANES *to = (LANES *)s->J;
    for (int i = 0; i < n; i++)
        for (int j = 0; j < 2 * m; j++) {
            const int by = j < m ? s->order[j] : n + s->order[j - m];
            for (int p = 0; p < PARTS; p++)
                to[(i * 2 * m + j) * PARTS + p] = J[((size_t)s->order[i] * width + by) * PARTS + p];
        }
}

/* y = right + J x of `rows` coordinates, whose number and that of columns are known to the compiler: their sums stay in registers. */
static INLINE void NAMED(multiply_rows)(int rows, int side, size_t count, const LANES *J, const LANES *right,
                                        const LANES *x, LANES *y)
{
    LANES sum[GROUP * PARTS];
    for (int i = 0; i < rows * side * PARTS; i++)
        sum[i] = right[i];
    for (size_t j = 0; j < count; j++, J += PARTS, x += side * PARTS)
        for (int i = 0; i < rows; i++)
            for (int l = 0; l < side; l++)
                for (int p = 0; p < PARTS; p++)
                    sum[(i * side + l) * PARTS + p] += J[i * count * PARTS + p] * x[l * PARTS + p];
    for (int i = 0; i < rows * side * PARTS; i++)
        y[i] = sum[i];
}

/* y = right + J x of coordinates from `first` on */
static INLINE void NAMED(multiply)(int side, const struct sweeping_step *s, int first, int end, const double *right,
                                   const double *x, double *y)
{
    const int count = 2 * s->acting, size = side * NODES;
    int i = first;
    for (; i + GROUP / side <= end; i += GROUP / side)
        NAMED(multiply_rows)(GROUP / side, side, count, (const LANES *)(s->J + i * count * NODES),
                             (const LANES *)(right + i * size), (const LANES *)x, (LANES *)(y + i * size));
    for (; GROUP / side >= 8 && i + 4 <= end; i += 4)
        NAMED(multiply_rows)(4, side, count, (const LANES *)(s->J + i * count * NODES),
                             (const LANES *)(right + i * size), (const LANES *)x, (LANES *)(y + i * size));
    for (; GROUP / side >= 4 && i + 2 <= end; i += 2)
        NAMED(multiply_rows)(2, side, count, (const LANES *)(s->J + i * count * NODES),
                             (const LANES *)(right + i * size), (const LANES *)x, (LANES *)(y + i * size));
    for (; i < end; i++)
        NAMED(multiply_rows)(1, side, count, (const LANES *)(s->J + i * count * NODES),
                             (const LANES *)(right + i * size), (const LANES *)x, (LANES *)(y + i * size));
}

/* What the accelerations w of `some` coordinates, whose number the compiler knows, add to places and rates at the nodes */
static INLINE void NAMED(integrate_some)(int some, const struct sweeping_step *s, const double *w, LANES *places,
                                         LANES *rates)
{
    LANES once[PAIR * PARTS], twice[PAIR * PARTS];
    const LANES *A = (const LANES *)s->once, *B = (const LANES *)s->twice;
    for (int i = 0; i < some; i++)
        for (int p = 0; p < PARTS; p++) {
            once[i * PARTS + p] = w[i * NODES] * A[p];
            twice[i * PARTS + p] = w[i * NODES] * B[p];
        }
    for (int l = 1; l < NODES; l++)
        for (int i = 0; i < some; i++)
            for (int p = 0; p < PARTS; p++) {
                once[i * PARTS + p] += w[i * NODES + l] * A[l * PARTS + p];
                twice[i * PARTS + p] += w[i * NODES + l] * B[l * PARTS + p];
            }
    for (int i = 0; i < some * PARTS; i++) {
        places[i] = twice[i];
        rates[i] = once[i];
    }
}

/* The same of all coordinates that act */
static INLINE void NAMED(integrate)(int side, const struct sweeping_step *s, const double *w, double *place)
{
    const int count = s->acting * side;
    LANES *places = (LANES *)place, *rates = places + count * PARTS;
    int i = 0;
    for (; i + PAIR <= count; i += PAIR)
        NAMED(integrate_some)(PAIR, s, w + i * NODES, places + i * PARTS, rates + i * PARTS);
    for (; i < count; i++)
        NAMED(integrate_some)(1, s, w + i * NODES, places + i * PARTS, rates + i * PARTS);
}

/* The largest numbers of each column of x[count][side][NODES], or of its differences to `less` */
static INLINE void NAMED(largest)(int side, int count, const double *x, const double *less, double *found)
{
    const int size = side * NODES;
    double most[GROUP * NODES] = {0.0};
    for (int i = 0; i < count; i++)
        for (int k = 0; k < size; k++) {
            const double one = fabs(less ? x[i * size + k] - less[i * size + k] : x[i * size + k]);
            most[k] = one > most[k] ? one : most[k];
        }
    for (int l = 0; l < side; l++) {
        found[l] = most[l * NODES];
        for (int k = 1; k < NODES; k++)
            found[l] = most[l * NODES + k] > found[l] ? most[l * NODES + k] : found[l];
    }
}

/* kept = right + J integrals of it, of the coordinates that act; 0 where sweeps do not find it. Each column ends when it is done: what is found
 * does not depend on the columns beside it. */
static INLINE int NAMED(sweep)(int side, const struct sweeping_step *s, struct sweeping_room *r)
{
    const int m = s->acting, size = side * NODES;
    double change[GROUP], before[GROUP], most[GROUP], sizes[GROUP];
    int left = side, ended[GROUP] = {0};
    NAMED(largest)(side, m, r->right, NULL, most);
    for (int l = 0; l < side; l++)
        before[l] = INFINITY;
    memcpy(r->w, r->right, (size_t)m * size * sizeof *r->w);
    for (int k = 0; k < SWEEPS && left; k++) {
        NAMED(integrate)(side, s, r->w, r->place);
        NAMED(multiply)(side, s, 0, m, r->right, r->place, r->next);
        NAMED(largest)(side, m, r->next, r->w, change);
        NAMED(largest)(side, m, r->next, NULL, sizes);
        double *found = r->next;
        r->next = r->w;
        r->w = found;
        for (int l = 0; l < side; l++) {
            const int state = ended[l] ? 0 : done(change[l], before[l], sizes[l]);
            most[l] = fmax(most[l], sizes[l]);
            before[l] = change[l];
            if (state < 0 || (state > 0 && most[l] > GROWS * sizes[l]))
                return 0;
            for (int i = 0; i < m && state > 0; i++)
                memcpy(r->kept + i * size + l * NODES, found + i * size + l * NODES, NODES * sizeof *found);
            ended[l] |= state;
            left -= state;
        }
    }
    return !left;
}

/* What accelerations at the nodes are by the differences at the start of the step and by arguments. `whole` has rows of `columns`. */
static INLINE void NAMED(begin)(int side, const struct sweeping_step *s, int columns, const double *whole,
                                struct sweeping_room *r)
{
    const struct carrying *step = s->of;
    const int n = step->n, m = s->acting, arguments = step->width - 2 * n;
    for (int i = 0; i < m; i++)
        for (int l = 0; l < side; l++) {
            const double q = whole[s->order[i] * columns + l], u = whole[(n + s->order[i]) * columns + l];
            for (int k = 0; k < NODES; k++) {
                r->place[(i * side + l) * NODES + k] = q + s->c[k] * u;
                r->place[((m + i) * side + l) * NODES + k] = u;
            }
        }
    memset(r->next, 0, (size_t)n * side * NODES * sizeof *r->next);
    for (int i = 0; i < n; i++)
        for (int j = 0; j < arguments; j++) {
            const double *J = step->J + ((size_t)s->order[i] * step->width + 2 * n + j) * NODES;
            for (int l = 0; l < side; l++)
                for (int k = 0; k < NODES; k++)
                    r->next[(i * side + l) * NODES + k] += J[k] * whole[(2 * n + j) * columns + l];
        }
    NAMED(multiply)(side, s, 0, n, r->next, r->place, r->right);
}

/* Places and rates at the end of the step */
static INLINE void NAMED(end)(int side, const struct sweeping_step *s, int columns, double *whole, const double *w)
{
    const int n = s->of->n;
    for (int i = 0; i < n; i++)
        for (int l = 0; l < side; l++) {
            double *q = whole + s->order[i] * columns + l, *u = whole + (n + s->order[i]) * columns + l;
            double once = 0.0, twice = 0.0;
            for (int k = 0; k < NODES; k++) {
                once += s->b[0][k] * w[(i * side + l) * NODES + k];
                twice += s->b[1][k] * w[(i * side + l) * NODES + k];
            }
            *q += s->of->h * *u + twice;
            *u += once;
        }
}

/* Some columns of `whole` through the step, but for what puts its end back */
static INLINE int NAMED(carry_some)(int side, const struct sweeping_step *s, int columns, double *whole, double *room)
{
    const int n = s->of->n, m = s->acting, size = side * NODES;
    struct sweeping_room r = {.right = room,
                              .w = room + n * size,
                              .next = room + 2 * n * size,
                              .kept = room + 3 * n * size,
                              .place = room + 4 * n * size};
    NAMED(begin)(side, s, columns, whole, &r);
    if (!NAMED(sweep)(side, s, &r))
        return 0;
    if (m < n) {
        NAMED(integrate)(side, s, r.kept, r.place);
        NAMED(multiply)(side, s, m, n, r.right, r.place, r.kept);
    }
    NAMED(end)(side, s, columns, whole, r.kept);
    return 1;
}

static TARGET int NAMED(carry_all)(struct sweeping_step *s, int columns, double *whole, double *room)
{
    int first = 0, found = 1;
    NAMED(find_acting)(s);
    NAMED(take_derivatives)(s);
    for (; first + GROUP <= columns && found; first += GROUP)
        found = NAMED(carry_some)(GROUP, s, columns, whole + first, room);
    for (; GROUP > 2 && first + GROUP / 2 <= columns && found; first += GROUP / 2)
        found = NAMED(carry_some)(GROUP / 2, s, columns, whole + first, room);
    for (; first < columns && found; first++)
        found = NAMED(carry_some)(1, s, columns, whole + first, room);
    return found;
}

#undef INLINE
#undef LANES
#undef PARTS
#undef GROUP
#undef PAIR
#undef NAMED
#undef TARGET
#undef WIDTH
