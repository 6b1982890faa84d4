"""How often the gateway notices a fault, and how often it calls a wrong answer valid.

``python -m benchmarks.gateway_faults`` plays seeded episodes of every class of fault against a
gateway whose compensator is made of glass: it shows which readings it was given. So it is known of
each answer whether the readings are those of the cycle that it names, how old they are, and whether
the compensator's time is the machine's. ``harness`` plays, ``classes`` holds the faults, ``states``
the restarts.
"""
