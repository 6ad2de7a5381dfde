"""What moves celestial bodies, written from the literature in extended precision.

It shares with the solver the words and numbers of `mbs_ref.scene.celestial`, and no code: these are what its
kernels are judged by. Times are s from the scene's epoch, shape (m,); places and rates are (m, n_bodies, 3) in m
and m/s along ICRF axes; a field returns accelerations of that shape, m/s^2. Everything is `numpy.longdouble`.
"""
