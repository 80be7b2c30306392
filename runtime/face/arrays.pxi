# Numbers of the core as arrays.

def all_finite(const real[::1] x):
    """Whether all numbers are finite."""
    cdef Py_ssize_t i, n = x.shape[0], whole = n - n % 4
    cdef real a = 0.0, b = 0.0, c = 0.0, d = 0.0  # side by side: they do not wait for each other
    for i in range(0, whole, 4):
        a += 0.0 * x[i]
        b += 0.0 * x[i + 1]
        c += 0.0 * x[i + 2]
        d += 0.0 * x[i + 3]
    for i in range(whole, n):
        a += 0.0 * x[i]
    return a + b + c + d == 0.0


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
    cdef real[::1] out = found
    if count:
        memcpy(&out[0], x, count * sizeof(real))
    return found
