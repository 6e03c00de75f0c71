"""Time per mode of SciPy's eigsh on the matrices that `clangor modes --export` writes.

    mkdir FOLDER
    clangor modes box:0.26x0.005x0.26 --material glass --max-nodes 14000 --export FOLDER
    python3 eigsh.py FOLDER 20000 140

The last number is how many modes to ask for at first, rigid motions included; while they end below the limit it is
doubled. Needs SciPy. Prints the processor time of shift-invert Lanczos (ARPACK, factors by SuperLU), to be put beside
`cargo bench --profile release -p clangor-bake --bench eigensolver`.
"""

import sys
import time
from math import pi
from pathlib import Path

from scipy.io import mmread
from scipy.sparse.linalg import eigsh

folder, limit = Path(sys.argv[1]), float(sys.argv[2])
wanted = int(sys.argv[3]) if len(sys.argv) > 3 else 32
stiffness, mass = (mmread(folder / f"{name}.mtx").tocsc() for name in ("stiffness", "mass"))
size = stiffness.shape[0]
print(f"{size // 3} nodes", flush=True)
start = time.process_time()
while True:
    # Below zero, where the matrix is positive; the six rigid motions come first.
    squares, _ = eigsh(stiffness, min(wanted, size - 1), mass, sigma=-((2 * pi * 500.0) ** 2), which="LM")
    frequencies = sorted(abs(square) ** 0.5 / (2 * pi) for square in squares)
    if frequencies[-1] > limit or wanted >= size - 1:
        break
    wanted *= 2
spent = time.process_time() - start
modes = [frequency for frequency in frequencies[6:] if frequency < limit]
per_mode = 1e3 * spent / max(len(modes), 1)
print(f"{len(modes)} modes below {limit:.0f} Hz, {spent:.2f} CPU-s, {per_mode:.0f} ms per mode")
print("first:", ", ".join(f"{frequency:.2f}" for frequency in modes[:8]), "Hz")
