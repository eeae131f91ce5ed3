"""Rotations and poses as arrays: algebra, means, covariances."""
