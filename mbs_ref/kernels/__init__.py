"""Compiled element kernels. They see arrays only; `mbs_ref.system` builds the arrays from a scene."""
