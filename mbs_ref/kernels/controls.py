"""Places in a model's `control` array: what Python changes between steps."""

CONTROL_MODE_TIME = 0  # s, a time inside the current step: picks the signals' segments
CONTROL_VELOCITY_GAIN = 1  # 1/s, Baumgarte 2 g
CONTROL_POSITION_GAIN = 2  # 1/s^2, Baumgarte g^2
