"""Turns modules of this project into FMUs: a fast slave, a bundle of modules, a complete package.

`variables` and `slave` travel inside the FMUs and import the standard library and pythonfmu only;
the other modules run at build time.
"""
