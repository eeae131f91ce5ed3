"""Geometry of single shapes: boxes, distances, points, edges."""
