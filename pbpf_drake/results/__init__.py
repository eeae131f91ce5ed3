"""Errors, metrics, reports and plots of what was tracked."""
