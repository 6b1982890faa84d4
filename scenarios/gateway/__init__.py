"""The compensator on a CAN bus: frames, both ends, and what happens when something is wrong.

The DBC file is the only source of frames and signals. ``database`` and ``codec`` read it, ``e2e``
and ``supervision`` judge what arrives, ``link`` keeps the bus, ``node`` is the gateway, ``machine``
the control at the other end.
"""
