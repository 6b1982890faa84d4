"""Tests of the compensator."""
