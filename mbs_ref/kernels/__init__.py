"""Compiled element kernels. They see arrays only; `mbs_ref.cores.system` builds the arrays from a scene."""
