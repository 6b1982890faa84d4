"""From measured runs to a compensator file: sensitive points, error models, limits."""
