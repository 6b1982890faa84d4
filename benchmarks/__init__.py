"""Measurements, each a program: ``python -m benchmarks.NAME``.

| NAME | what it asks | its page in docs |
| --- | --- | --- |
| ``trust.run`` | how far a compensator can be trusted on runs unlike its training | results |
| ``lathe``, ``electric_spindle`` | how error models do by themselves on measured runs | results |
| ``probing`` | what probe cycles bring | results |
| ``monitoring`` | false alarms of `monitor`, and what it finds | results |
| ``broken_sensor``, ``sensor_faults.run`` | how broken sensors are borne, and found | results |
| ``studies`` | whether the three studies' figures are reached | studies |
| ``gap.run``, ``gap.table`` | whether the gap finder names what is hidden | gap_benchmark |
| ``gap.mistakes``, ``gap.agree`` | smaller questions of the same kind | gap_benchmark |
| ``drawing`` | what the page of a drawing is worth | results |
| ``lathe_x`` | what the measured lathe's X follows | gap |
| ``gateway_latency``, ``gateway_faults`` | how quick the gateway is, and how safe | results |
| ``peers``, ``native_plant_steps``, ``controller`` | what a step of an FMU costs | results |
| ``native_agreement`` | whether Python and C agree | native |
| ``bad_inputs.run`` | what each command says of bad input | results |
| ``house`` | how large the project is | results |

``results_page`` puts a table between its marks on a page; ``trust.questions`` holds the splits of
runs; ``learning`` fits an error model by itself.
"""

import os

# Before numpy is there: small matrices gain nothing from more threads, and get in each other's way.
for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")
