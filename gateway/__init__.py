"""The compensator on a CAN bus: the frames, both ends, and fault handling.

Frames and signals come from a DBC file: the gateway's own form (``dbc``) or any other, read through
a map (``mapping``). ``codec`` encodes and decodes frames, ``reception`` and ``judging`` check what
arrives, ``link`` connects to the bus, ``node`` is the gateway, ``machine`` the control at the other
end. ``protocols`` and ``controls`` hold plug-ins; ``linuxcnc`` is a real control.
"""
