"""The shared judge: constraints, energy and momentum from world poses and velocities alone.

NumPy only, apart from every solver and its compiled kernels, so that one code judges all engines.
"""

from mbs_ref.observables.constraints import Rows, constraint_rate, constraint_residual, rows
from mbs_ref.observables.energy import EnergyBalance, energy_balance, kinetic_energy, potential_energy
from mbs_ref.observables.momentum import angular_momentum, linear_momentum, momentum_drift

__all__ = [
    "EnergyBalance", "Rows", "angular_momentum", "constraint_rate", "constraint_residual", "energy_balance",
    "kinetic_energy", "linear_momentum", "momentum_drift", "potential_energy", "rows",
]  # fmt: skip
