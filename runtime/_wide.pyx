# cython: language_level=3, boundscheck=False, wraparound=False, embedsignature=True
"""The compiled face of the runtime once more, over long doubles."""

include "_core.pyx"
