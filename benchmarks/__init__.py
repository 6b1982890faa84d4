"""Benchmarks, each a program: ``python -m benchmarks.NAME``.

| NAME | question | page in docs |
| --- | --- | --- |
| ``trust.run`` | how far to trust a compensator on runs unlike its training | results |
| ``lathe`` | how accurate error models are on measured runs | results |
| ``probing`` | how much probe cycles help | results |
| ``monitoring`` | false alarms of `monitor`, and what it finds | results |
| ``broken_sensor``, ``sensor_faults.run`` | how broken sensors are detected and handled | results |
| ``studies`` | whether the three studies' figures are reproduced | studies |
| ``gap.run``, ``gap.table`` | whether the gap finder names hidden effects | gap_benchmark |
| ``gap.mistakes``, ``gap.agree`` | smaller questions of the same kind | gap_benchmark |
| ``drawing`` | how accurate a machine from a drawing page is | results |
| ``gateway_latency``, ``gateway_faults`` | how fast and how safe the gateway is | results |
| ``peers``, ``native_plant_steps``, ``controller`` | how long a step of an FMU takes | results |
| ``bad_inputs.run`` | how each command reports bad input | results |
| ``house`` | how large the project is | results |

``results_page`` writes tables into pages; ``trust.questions`` holds the splits of runs;
``learning`` fits an error model by itself.
"""

import os

# Before numpy is imported: small matrices gain nothing from more threads, which slow each other.
for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")
