"""A third machine to test the gap finder on: a whole lathe with feed axes and an enclosure.

Bars in fine stretches: spindle, headstock, bed, slides and screws. What is not physics (time
stepping, the form of tests, random walks) it has from ``benchmarks.gap.belt``; nothing of
``plant_model``. Its owner writes a file in lumps for every case.
"""
