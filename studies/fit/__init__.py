"""Fitting of the studies' error models."""
