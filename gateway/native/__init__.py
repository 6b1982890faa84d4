"""The gateway's frames in C, for a compensator FMU with a CAN terminal (FMI-LS-BUS)."""
