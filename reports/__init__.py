"""The command line and the pages."""

import os

# Matrices are small: a second thread of BLAS waits longer than it computes. NumPy reads this when it is imported.
os.environ.setdefault("OMP_NUM_THREADS", "1")
