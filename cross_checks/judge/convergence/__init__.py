"""One statistical model of convergence: every verdict, observed order and choice of a next setting queries it."""
