"""How a truth is converged: unlike integrators, extended precision, and their agreement."""
