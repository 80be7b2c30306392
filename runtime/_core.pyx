# cython: language_level=3, boundscheck=False, wraparound=False, embedsignature=True
"""The compiled face of the runtime: a model's kernels on batches of states, and whole runs without the GIL.

Arrays are C-contiguous, of the type ``REAL``, with a leading batch axis; :mod:`ccgen.runtime.model` prepares and checks
them. This file is compiled for doubles, and as ``_float`` and ``_wide`` for floats and long doubles.
"""

cimport cython
from cpython.bytes cimport PyBytes_FromStringAndSize
from cpython.exc cimport PyErr_CheckSignals
from cpython.pycapsule cimport PyCapsule_GetPointer, PyCapsule_IsValid
from libc.string cimport memcpy, memset

from collections import namedtuple
from functools import partial

import numpy as np

include "face/declarations.pxi"
include "face/arrays.pxi"
include "face/supply.pxi"
include "face/evaluations.pxi"
include "face/forces.pxi"
include "face/derivatives.pxi"
include "face/runs.pxi"
include "face/ensembles.pxi"


def methods(estimating=False):
    """Names of the integration methods; of those ``estimating`` their errors alone, so that a tolerance can choose steps."""
    cdef int i = 0
    if not isinstance(estimating, bool):
        raise TypeError(f"estimating: found {estimating!r}, expected True or False")
    names = []
    while all_methods[i] is not NULL:
        if not estimating or estimates_errors(all_methods[i]):
            names.append(all_methods[i].name.decode())
        i += 1
    return tuple(names)

