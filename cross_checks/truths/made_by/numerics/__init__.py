"""Truths by arithmetic alone: convergent integration and quadrature, jets, elliptic functions, differences."""
