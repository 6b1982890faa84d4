"""The gateway's frames in C: a compensator FMU with a CAN terminal (FMI-LS-BUS)."""
