"""A machine to test the gap finder on: many cells, laws of its own, effects that can be hidden.

It plays the measured machine. So it shares nothing with ``plant_model``: neither code, nor
discretisation, nor film and gap correlations, nor parameter values.
"""
