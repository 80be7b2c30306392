# Numbers of the core as arrays.

def all_finite(const real[::1] x):
    """Whether all numbers are finite."""
    return numbers_finite(x.shape[0], &x[0])


def never_decreases(const real[::1] x):
    """Whether no number is less than the one before it."""
    cdef Py_ssize_t i
    for i in range(1, x.shape[0]):
        if x[i] < x[i - 1]:
            return False
    return True


def all_within(const real[::1] x, real limit):
    """Whether all numbers are smaller than ``limit`` in size."""
    return numbers_within(x.shape[0], &x[0], limit)


def sure_inverses(const real[:, :, ::1] matrices, real sure):
    """Inverses (b, k, k) of matrices, and which of them (b,) are surely regular; see invert_sure."""
    cdef Py_ssize_t i, b = matrices.shape[0], k = matrices.shape[1]
    found, regular = zeros((b, k, k)), np.ones(b, dtype=bool)
    cdef real[:, :, ::1] out = found
    cdef real[::1] scratch = empty(2 * k * (k + 1) + 1)
    if k:
        for i in range(b):
            if not invert_sure(k, &matrices[i, 0, 0], sure, &out[i, 0, 0], &scratch[0]):
                regular[i] = False
    return found, regular


cdef object _columns(const real *x, size_t rows, size_t stride, size_t width):
    """The first ``width`` of every ``stride`` numbers, (rows, width)."""
    found = empty((rows, width))
    cdef real[:, ::1] out = found
    cdef size_t i
    for i in range(rows):
        memcpy(&out[i, 0], x + i * stride, width * sizeof(real))
    return found


cdef object _numbers(const real *x, size_t count):
    found = empty(count)
    cdef real[::1] out
    if count:  # short runs have many arrays of nothing
        out = found
        memcpy(&out[0], x, count * sizeof(real))
    return found
