"""What the cores of rigid bodies share, in the plane and in space: closed loops, and the reduction to an ODE."""
