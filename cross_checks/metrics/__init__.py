"""What is measured of a run, one file a metric; all look at world poses and velocities."""
