"""What every FMU without Python shares: the FMI front in C99, its build and the compilers."""
