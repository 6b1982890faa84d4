"""``python -m spindle_drift`` is the command ``spindle-drift``."""

from __future__ import annotations

import sys

from scenarios.entry import main

sys.exit(main())
