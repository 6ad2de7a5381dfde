"""The planar core: three coordinates a body, blocks of at most three rows a joint, O(N) elimination."""
