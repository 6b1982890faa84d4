"""The compensator on a CAN bus: frames, both ends, and what happens when something is wrong.

Frames and signals come from the DBC file alone. ``database`` and ``codec`` read it, ``e2e`` and
``supervision`` check what arrives, ``link`` connects to the bus, ``node`` is the gateway,
``machine`` the control at the other end.
"""
