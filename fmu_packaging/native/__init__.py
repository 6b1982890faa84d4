"""Shared parts of all FMUs without Python: the FMI front in C99, its build and the compilers."""
